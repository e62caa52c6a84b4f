#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/house/source_tree.h"
#include "tests/support/read_file.h"

// What pages quote of the code, between backticks, has to be so.
namespace palpate::house {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

/// What a page may quote.
struct Sources {
  std::set<std::string> files;    ///< relative to the root, and folders
  std::set<std::string> endings;  ///< what a path may be shortened to: "physics/limits.h"
  std::set<std::string> words;    ///< identifiers, and whatever else looks like one
  /// What follows `=`; several constants may share a name.
  std::multimap<std::string, std::string> constants;
};

void Add(const std::string& file, const std::string& text, Sources& sources) {
  for (fs::path path = file; !path.empty(); path = path.parent_path()) {
    for (std::string end = path.string();; end = end.substr(end.find('/') + 1)) {
      sources.endings.insert(end);
      if (end.find('/') == end.npos) break;
    }
    sources.files.insert(path.string());
  }
  std::string word;
  for (const char c : text + '\n') {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
      word += c;
    } else if (!word.empty()) {
      sources.words.insert(std::exchange(word, ""));
    }
  }
  static const std::regex kConstant(R"(\b(k[A-Z]\w*)\s*=\s*([\w.:'*/ -]+?)\s*[,;])");
  for (std::size_t at = text.find("constexpr "); at != text.npos;
       at = text.find("constexpr ", at + 1)) {
    const std::string declared = text.substr(at, text.find(';', at) + 1 - at);
    for (std::sregex_iterator it(declared.begin(), declared.end(), kConstant), end; it != end;
         ++it) {
      sources.constants.emplace((*it)[1], (*it)[2]);
    }
  }
}

/// The value of a product of numbers and constants, the first of several of a name.
std::optional<double> ValueOf(std::string product, const Sources& sources) {
  std::erase(product, '\'');
  double value = 1.0;
  std::istringstream factors(product);
  for (std::string factor; factors >> factor;) {
    if (factor == "*") continue;
    char* end = nullptr;
    const double number = std::strtod(factor.c_str(), &end);
    if (*end == '\0') {
      value *= number;
    } else if (const auto named = sources.constants.find(factor);
               named != sources.constants.end() && named->second != product) {
      const auto of_it = ValueOf(named->second, sources);
      if (!of_it) return std::nullopt;
      value *= *of_it;
    } else {
      return std::nullopt;
    }
  }
  return value;
}

double NumberOf(std::string said, const std::string& unit) {
  static const std::map<std::string, double> kWords = {
      {"a quarter", 0.25}, {"half", 0.5}, {"two", 2},   {"three", 3},   {"four", 4}, {"five", 5},
      {"six", 6},          {"seven", 7},  {"eight", 8}, {"twelve", 12}, {"ten", 10}};
  static const std::map<std::string, double> kUnits = {{"%", 1e-2},  {"mm", 1e-3}, {"ms", 1e-3},
                                                       {"µm", 1e-6}, {"µs", 1e-6}, {"nm", 1e-9}};
  std::erase(said, ',');
  const auto word = kWords.find(said);
  const auto factor = kUnits.find(unit);
  return (word != kWords.end() ? word->second : std::stod(said)) *
         (factor != kUnits.end() ? factor->second : 1.0);
}

/// The quotes of a page that are not so, in its order.
/// @param text  the page's own
std::vector<std::string> Untrue(const std::string& page, std::string text, const Sources& sources) {
  std::vector<std::string> untrue;
  static const std::regex kQuote("`([^`\n]+)`"), kPath(R"([\w./-]+)"),
      kSource(R"(.*\.(cpp|h|inl|idl|fbs|ts|mjs|cmake|md))"), kName("k[A-Z]\\w*|([A-Z]\\w*::)+\\w+"),
      kType("[A-Z][a-z]+[A-Z]\\w*"), kWord("\\w+");
  for (std::size_t block = text.find("```"); block != text.npos; block = text.find("```", block)) {
    const std::size_t end = text.find("```", block + 3);
    text.erase(block, end == text.npos ? end : end + 3 - block);
  }
  for (std::sregex_iterator it(text.begin(), text.end(), kQuote), end; it != end; ++it) {
    const std::string quote = (*it)[1];
    // Figures name what others have, too.
    if (std::regex_match(quote, kName) ||
        (std::regex_match(quote, kType) && !IsBelow(page, "tests/benchmarks"))) {
      for (std::sregex_iterator word(quote.begin(), quote.end(), kWord); word != end; ++word) {
        if (!sources.words.contains(word->str())) untrue.push_back(quote + " is in no source");
      }
    }
    if (!std::regex_match(quote, kPath) || quote.starts_with('/')) continue;
    const std::string path = quote.substr(0, quote.find_last_not_of('/') + 1);
    const bool is_of_the_root =
        quote.find('/') != quote.npos && sources.files.contains(quote.substr(0, quote.find('/')));
    if (!is_of_the_root && !std::regex_match(quote, kSource)) continue;
    const std::string beside = (fs::path(page).parent_path() / path).lexically_normal().string();
    // What is no file of the repository may be one that a program writes or that is installed.
    const bool is_written = !is_of_the_root && sources.words.contains(fs::path(path).stem());
    if (!sources.endings.contains(path) && !sources.files.contains(beside) && !is_written) {
      untrue.push_back(quote + " is no file");
    }
  }

  // A number, its unit, at most nine words, and the constant in parentheses.
  static const std::regex kNumber(
      R"(([0-9]+(?:,[0-9]{3})*(?:\.[0-9]+)?|a quarter|half|two|three|four|five|six|seven|eight|ten|twelve))"
      R"( ?(%|mm|ms|µm|µs|nm)?((?: [^\s`().,;:0-9]+){0,9}) \(`(k[A-Z]\w*)`)");
  text = std::regex_replace(text, std::regex("\\s+"), " ");
  for (std::sregex_iterator it(text.begin(), text.end(), kNumber), end; it != end; ++it) {
    const double said = NumberOf((*it)[1], (*it)[2]);
    const auto [begin, last] = sources.constants.equal_range((*it)[4]);
    const auto is_it = [&](const auto& constant) {
      const std::optional<double> value = ValueOf(constant.second, sources);
      // A fraction may be stated as what it divides by.
      return value && (std::abs(*value - said) <= 1e-9 * std::abs(said) ||
                       (said < 1.0 && std::abs(*value * said - 1.0) < 1e-9));
    };
    if (std::none_of(begin, last, is_it)) {
      untrue.push_back((*it)[1].str() + " is not " + (*it)[4].str() +
                       (begin == last ? "" : " = " + begin->second));
    }
  }
  return untrue;
}

TEST(Quotes, AreFoundUntrueWhereTheSourcesSayOtherwise) {
  Sources sources;
  Add("server/physics/limits.h",
      "inline constexpr int kIterates = 16, kReserve = 4;\n"
      "constexpr double kMaxTruncation = 0.5e-6, kFar = kIterates * 1e-3; write(\"METHODS.md\");",
      sources);
  const auto untrue = [&](const std::string& text) {
    return Untrue("server/README.md", text, sources);
  };
  EXPECT_THAT(
      untrue("`physics/limits.h`, `limits.h`, `server/physics/`, `out/METHODS.md`, `a.txt`"),
      IsEmpty());
  EXPECT_THAT(untrue("`physics/gone.h` and `server/gone`"),
              ElementsAre("physics/gone.h is no file", "server/gone is no file"));
  EXPECT_THAT(untrue("`kIterates`, `kGone`, `Limits::kFar`, `WasRenamed`\n```\n`kIgnored`\n```"),
              ElementsAre("kGone is in no source", "Limits::kFar is in no source",
                          "WasRenamed is in no source"));
  EXPECT_THAT(
      untrue("at most 16 iterates (`kIterates`), 0.5 µm along\nthe plane (`kMaxTruncation`, "
             "taken), 16 mm (`kFar`), a quarter is kept (`kReserve`)"),
      IsEmpty());
  EXPECT_THAT(untrue("at most 8 iterates (`kIterates`); 1 µm (`kMaxTruncation`)"),
              ElementsAre("8 is not kIterates = 16", "1 is not kMaxTruncation = 0.5e-6"));
}

TEST(Quotes, OfEveryPageAreTrue) {
  const std::string root = std::string(PALPATE_SOURCE_DIR) + "/";
  Sources sources;
  std::vector<std::string> pages;
  for (const std::string& file : SourceFiles(root)) {
    const bool is_page = file.ends_with(".md");
    if (is_page) pages.push_back(file);
    static const std::regex kCode(
        R"(.*(\.(cpp|h|h\.in|inl|c|idl|fbs|ts|mjs|py|yaml|cmake|txt)|/[a-z_]+))");
    Add(file, std::regex_match(file, kCode) ? ReadWholeFile(root + file) : "", sources);
  }
  for (const std::string& page : pages) {
    EXPECT_THAT(Untrue(page, ReadWholeFile(root + page), sources), IsEmpty()) << page;
  }
}

TEST(Architecture, NamesEveryFloorOfThePhysics) {
  const std::string root = PALPATE_SOURCE_DIR;
  const std::string text = ReadWholeFile(root + "/server/ARCHITECTURE.md");
  for (const auto& entry : fs::directory_iterator(root + "/server/physics")) {
    if (!entry.is_directory()) continue;
    const std::string floor = "| `" + entry.path().filename().string() + "/` |";
    EXPECT_NE(text.find(floor), text.npos) << "server/ARCHITECTURE.md has no row " << floor;
  }
}

}  // namespace
}  // namespace palpate::house
