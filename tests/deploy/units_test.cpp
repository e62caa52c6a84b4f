// The units of deploy/systemd, as systemd judges them.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/house/source_tree.h"
#include "tests/support/read_file.h"

namespace palpate::house {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

const fs::path kUnits = PALPATE_SOURCE_DIR "/deploy/systemd";
/// Of 10, by systemd-analyze security: what a service could do.  An ordinary one has 9.6.
constexpr double kMostExposure = 2.0;

/// The units as installed, with the programs of this build.
class Units : public testing::Test {
 protected:
  void SetUp() override {
    if (RunCommand({"sh", "-c", "command -v systemd-analyze"}).exit_code != 0) {
      GTEST_SKIP() << "systemd-analyze is missing: install the package systemd";
    }
    fs::create_directories(folder_ / "bin");
    for (const std::string program : {"iox-roudi", "palpate-server", "palpate-viewer"}) {
      fs::create_symlink("/bin/true", folder_ / "bin" / program);
    }
    for (const auto& entry : fs::recursive_directory_iterator(kUnits)) {
      if (entry.path().extension() == ".env" || entry.is_directory()) continue;
      const fs::path target = folder_ / fs::relative(entry.path(), kUnits);
      fs::create_directories(target.parent_path());
      std::ofstream(target) << std::regex_replace(
          ReadWholeFile(entry.path()), std::regex("=/usr/bin/"), "=" + (folder_ / "bin/").string());
      if (target.extension() == ".service") names_.push_back(target.filename());
    }
    ASSERT_EQ(names_.size(), 4u);
  }
  ~Units() override { fs::remove_all(folder_); }

  Output Analyse(std::vector<std::string> words) const {
    words.insert(words.begin(),
                 {"/usr/bin/env", "SYSTEMD_UNIT_PATH=" + folder_.string() + ":/lib/systemd/system",
                  "systemd-analyze"});
    return RunCommand(words);
  }
  Output Verify(const std::string& unit) const {
    return Analyse({"verify", "--man=no", (folder_ / unit).string()});
  }

  std::vector<std::string> names_;
  const fs::path folder_ =
      fs::temp_directory_path() / ("palpate_units_" + std::to_string(getpid()));
};

TEST_F(Units, AreWhatSystemdUnderstands) {
  for (const std::string& unit : names_) {
    const Output output = Verify(unit);
    EXPECT_EQ(output.exit_code, 0) << output.text;
    EXPECT_THAT(output.text, Not(HasSubstr("palpate"))) << "it has something to say of it";
  }
}

TEST_F(Units, WouldBeToldOfAWordThatSystemdDoesNotKnow) {
  std::ofstream(folder_ / "palpate-server.service", std::ios::app)
      << "[Service]\nRestrictAdressFamilies=AF_UNIX\n";
  EXPECT_THAT(Verify("palpate-server.service").text, HasSubstr("RestrictAdressFamilies"));
}

TEST_F(Units, ExposeLittle) {
  static const std::regex kExposure("exposure level for (\\S+): ([0-9.]+)");
  for (const std::string& unit : names_) {
    const Output output =
        Analyse({"security", "--offline=yes", "--no-pager", (folder_ / unit).string()});
    std::smatch match;
    ASSERT_TRUE(std::regex_search(output.text, match, kExposure)) << output.text;
    EXPECT_LE(std::stod(match[2]), kMostExposure) << output.text;
  }
}

TEST(Unit, OfTheServerHasTheLimitsThatPeopleHave) {
  const std::string unit = ReadWholeFile(kUnits / "palpate-server.service");
  const std::string limits = ReadWholeFile(PALPATE_SOURCE_DIR "/deploy/packages/limits.conf");
  EXPECT_THAT(unit, HasSubstr("LimitRTPRIO=45\n"));
  EXPECT_THAT(limits, HasSubstr("rtprio   45\n"));
  EXPECT_THAT(unit, HasSubstr("LimitMEMLOCK=infinity\n"));
  EXPECT_THAT(limits, HasSubstr("memlock  unlimited\n"));
}

TEST(Unit, OfEachClientOfRouDiStartsAndEndsWithIt) {
  for (const std::string unit : {"palpate-server.service", "palpate-record.service"}) {
    const std::string text = ReadWholeFile(kUnits / unit);
    for (const std::string word : {"BindsTo", "PartOf", "WantedBy"}) {
      EXPECT_THAT(text, HasSubstr(word + "=palpate-roudi.service\n")) << unit;
    }
    EXPECT_THAT(text, HasSubstr("\nAfter=")) << unit;
    EXPECT_THAT(text, HasSubstr("\nPrivateTmp=no\n")) << unit << ": RouDi's socket is in /tmp";
  }
}

}  // namespace
}  // namespace palpate::house
