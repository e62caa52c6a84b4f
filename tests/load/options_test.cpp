#include "client/load/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/command_line.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::optional<LoadRunOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseLoadOptions, words);
}

std::string Complaint(const std::vector<const char*>& words) {
  return test::ComplaintOf(ParseLoadOptions, words);
}

TEST(LoadOptions, AreOneStationAndNoViewerUnlessTold) {
  const auto options = Parse({});
  ASSERT_TRUE(options);
  EXPECT_THAT(options->stations, ElementsAre(1));
  EXPECT_THAT(options->viewers, ElementsAre(0));
  EXPECT_EQ(options->viewer_url.text(), "ws://127.0.0.1:8765");
  EXPECT_EQ(options->scene, "");
  EXPECT_FALSE(options->find);
  EXPECT_FALSE(options->server_pid);
  EXPECT_EQ(options->copies, 0u);
}

TEST(LoadOptions, TakeSeveralNumbersForAReport) {
  const auto options =
      Parse({"--stations", "1,4,16", "--viewers", "0,200", "--report", "capacity.md"});
  ASSERT_TRUE(options);
  EXPECT_THAT(options->stations, ElementsAre(1, 4, 16));
  EXPECT_THAT(options->viewers, ElementsAre(0, 200));
  EXPECT_EQ(options->command, "palpate --stations 1,4,16 --viewers 0,200 --report capacity.md");
}

TEST(LoadOptions, TakeTheGatewaysAddressWithAndWithoutASlash) {
  for (const std::string url : {"ws://10.0.0.7:9000", "ws://10.0.0.7:9000/"}) {
    EXPECT_EQ(ParseViewerUrl(url).host, "10.0.0.7");
    EXPECT_EQ(ParseViewerUrl(url).port, 9000);
  }
  for (const std::string url :
       {"", "http://127.0.0.1:8765", "ws://127.0.0.1", "ws://:8765",
        "ws://127.0.0.1:", "ws://127.0.0.1:0", "ws://127.0.0.1:70000", "ws://127.0.0.1:87a5"}) {
    EXPECT_THROW(ParseViewerUrl(url), UsageError) << url;
  }
}

TEST(LoadOptions, TakeANumberOfToolsAndAFileForAScene) {
  const auto options = Parse({"--make-scene", "32", "many.json"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->copies, 32u);
  EXPECT_EQ(options->copies_file, "many.json");
  EXPECT_THAT(Complaint({"--make-scene", "many", "many.json"}), HasSubstr("1 to 1000"));
  EXPECT_THAT(Complaint({"--make-scene", "0", "many.json"}), HasSubstr("1 to 1000"));
  EXPECT_THAT(Complaint({"--make-scene", "32", "many"}), HasSubstr(".json"));
}

TEST(LoadOptions, NameTheArgumentThatIsWrong) {
  EXPECT_THAT(Complaint({"--stations", "many"}), HasSubstr("--stations"));
  EXPECT_THAT(Complaint({"--seconds", "0"}), HasSubstr("--seconds"));
  EXPECT_THAT(Complaint({"--name", "no blanks"}), HasSubstr("--name"));
  EXPECT_THAT(Complaint({"--transport", "tcp"}), HasSubstr("tcp"));
  EXPECT_THAT(Complaint({"--realtime", "very"}), HasSubstr("very"));
}

}  // namespace
}  // namespace palpate
