#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/house/source_tree.h"
#include "tests/support/read_file.h"

// What must stay true of the repository.
namespace palpate::house {
namespace {

const std::string kRoot = PALPATE_SOURCE_DIR;

/// The first line with a match of the regular expression, as "line: text"; empty: there is none.
std::string FirstMatch(const std::string& text, const std::string& regex) {
  std::smatch match;
  if (!std::regex_search(text, match, std::regex(regex))) return "";
  const auto line = 1 + std::count(text.begin(), match[0].first, '\n');
  return std::to_string(line) + ": " + match[0].str();
}

// Written in two halves, so that this file does not match itself.
const std::string kLeftForLater = std::string("\\b(TO") + "DO|FIX" + "ME|XX" + "X|HA" + "CK)\\b";
const std::string kSomebodysFolder = std::string("/(home|Us") + "ers)/[a-z]";
const std::string kRegistryHost = std::string("(registry\\.npm") + "js|deb\\.deb" + "ian|docker" +
                                  "\\.io|gh" + "cr\\.io|qu" + "ay\\.io|pypi\\.or" + "g)";

bool IsText(const std::string& file) {
  static const std::set<std::string> kBinary = {".png", ".jpg", ".stl", ".ply",
                                                ".3ds", ".glb", ".mcap"};
  return !kBinary.contains(std::filesystem::path(file).extension());
}

TEST(FirstMatch, FindsWhatIsNotAllowedAndNothingElse) {
  EXPECT_EQ(FirstMatch(std::string("a\n// TO") + "DO: b", kLeftForLater),
            std::string("2: TO") + "DO");
  EXPECT_EQ(FirstMatch("a\n// todos are fine", kLeftForLater), "");
  EXPECT_EQ(FirstMatch(std::string("cd /ho") + "me/eve", kSomebodysFolder),
            std::string("1: /ho") + "me/e");
  EXPECT_EQ(FirstMatch("the user's home/cache", kSomebodysFolder), "");
  EXPECT_NE(FirstMatch(std::string("https://registry.npm") + "js.org/a", kRegistryHost), "");
}

TEST(Repository, HasAtItsTopOnlyWhatBelongsThere) {
  const std::set<std::string> allowed = {".ci",
                                         ".clang-format",
                                         ".gitignore",
                                         "CHANGELOG.md",
                                         "client",
                                         "common",
                                         "CMakeLists.txt",
                                         "CMakePresets.json",
                                         "CONTRIBUTING.md",
                                         "deploy",
                                         "devices",
                                         "idl",
                                         "LICENSE",
                                         "README.md",
                                         "scenes",
                                         "server",
                                         "tests"};
  std::set<std::string> top;
  for (const std::string& file : TrackedFiles(kRoot)) top.insert(file.substr(0, file.find('/')));
  EXPECT_EQ(top, allowed);
}

TEST(Repository, ShowsOnePosesWayThroughSixFilesThatExist) {
  const std::vector<std::string> path = {"idl/haptics.idl",
                                         "server/transport/station_link.cpp",
                                         "server/session/servo_loop.cpp",
                                         "server/physics/haptic_step.cpp",
                                         "server/physics/contact/sub_step.cpp",
                                         "server/physics/solve/response.cpp"};
  for (const std::string& file : path) {
    EXPECT_TRUE(std::filesystem::is_regular_file(kRoot + "/" + file)) << file << " is missing";
  }
  const std::string text = ReadWholeFile(kRoot + "/server/ARCHITECTURE.md");
  std::size_t at = 0;
  for (const std::string& file : path) {
    const std::size_t next = text.find(file, at);
    EXPECT_NE(next, std::string::npos)
        << "server/ARCHITECTURE.md does not name " << file << " in its turn";
    if (next != std::string::npos) at = next;
  }
}

/// What a link may name after '#': a page's headings, spelled as Git hosts do.
std::set<std::string> Anchors(const std::string& page) {
  std::set<std::string> anchors;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of("# ");
    if (!line.starts_with('#') || begin == line.npos) continue;
    std::string anchor;
    for (const unsigned char c : line.substr(begin)) {
      if (c == ' ') anchor += '-';
      if (std::isalnum(c) || c == '-' || c == '_') anchor += static_cast<char>(std::tolower(c));
    }
    anchors.insert("#" + anchor);
  }
  return anchors;
}

TEST(Repository, LinksOnlyToFilesAndHeadingsThatExist) {
  static const std::regex kLink(R"(\]\(([^)#:\s]*)(#[^)\s]*)?\))");
  for (const std::string& file : SourceFiles(kRoot)) {
    if (!file.ends_with(".md")) continue;
    const std::string page = kRoot + "/" + file;
    const std::string text = ReadWholeFile(page);
    for (std::sregex_iterator it(text.begin(), text.end(), kLink), end; it != end; ++it) {
      const std::string target = (*it)[1], heading = (*it)[2];
      const std::string linked =
          target.empty() ? page : (std::filesystem::path(page).parent_path() / target).string();
      EXPECT_TRUE(std::filesystem::exists(linked)) << file << " links to " << target;
      if (heading.empty() || !linked.ends_with(".md")) continue;
      EXPECT_TRUE(Anchors(ReadWholeFile(linked)).contains(heading))
          << file << " links to " << target << heading;
    }
  }
}

TEST(Repository, HasPagesOfAtMost2500Words) {
  for (const std::string& file : SourceFiles(kRoot)) {
    if (!file.ends_with(".md")) continue;
    std::istringstream words(ReadWholeFile(kRoot + "/" + file));
    EXPECT_LE(std::distance(std::istream_iterator<std::string>(words), {}), 2500) << file;
  }
}

TEST(Repository, BuildsEveryTest) {
  std::string lists;
  const std::vector<std::string> files = SourceFiles(kRoot);
  for (const std::string& file : files) {
    if (file.ends_with("CMakeLists.txt")) lists += ReadWholeFile(kRoot + "/" + file);
  }
  for (const std::string& file : files) {
    if (!file.ends_with("_test.cpp")) continue;
    const std::string name = std::filesystem::path(file).filename().string();
    EXPECT_NE(FirstMatch(lists, "[ /]" + name), "") << file << " is in no CMakeLists.txt";
  }
}

TEST(Repository, LinksToEveryReportOfFigures) {
  const std::string folder = "tests/benchmarks/results/";
  const std::string figures = ReadWholeFile(kRoot + "/" + folder + "README.md");
  for (const std::string& file : SourceFiles(kRoot)) {
    if (!file.starts_with(folder) || file == folder + "README.md") continue;
    EXPECT_NE(figures.find("](" + file.substr(folder.size()) + ")"), std::string::npos) << file;
  }
}

TEST(Repository, LeavesNothingForLaterAndNamesNoPlaceOfItsMakers) {
  for (const std::string& file : SourceFiles(kRoot)) {
    if (!IsText(file)) continue;
    const std::string text = ReadWholeFile(kRoot + "/" + file);
    EXPECT_EQ(FirstMatch(text, kLeftForLater), "") << file;
    EXPECT_EQ(FirstMatch(text, kSomebodysFolder), "") << file;
    EXPECT_EQ(FirstMatch(text, kRegistryHost), "") << file;
  }
}

// Eigen's has a singular value decomposition: eight to twenty seconds of compile time for each
// source.
TEST(Repository, TurnsOneVectorIntoAnotherByRotationBetween) {
  const std::string eigens = std::string("::FromTwo") + "Vectors(";
  for (const std::string& file : SourceFiles(kRoot)) {
    if (!file.ends_with(".cpp") && !file.ends_with(".h")) continue;
    EXPECT_EQ(ReadWholeFile(kRoot + "/" + file).find(eigens), std::string::npos) << file;
  }
}

TEST(Repository, IsFormattedAsItsClangFormatFileSays) {
  std::vector<std::string> words = {"clang-format", "--dry-run", "-Werror"};
  for (const std::string& file : SourceFiles(kRoot)) {
    if (file.ends_with(".h") || file.ends_with(".cpp")) words.push_back(kRoot + "/" + file);
  }
  if (RunCommand({"sh", "-c", "command -v clang-format"}).exit_code != 0) {
    GTEST_SKIP() << "clang-format is missing: deploy/setup --for tests installs it";
  }
  const Output output = RunCommand(words);
  EXPECT_EQ(output.exit_code, 0) << output.text;
}

}  // namespace
}  // namespace palpate::house
