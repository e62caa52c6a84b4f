#include "client/recorder/options.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/command_line.h"

namespace palpate {
namespace {

using testing::ElementsAre;

std::optional<RecorderOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseRecorderOptions, words);
}

TEST(RecorderOptions, NeedAFileAndHaveDefaultsForTheRest) {
  const auto options = Parse({"-o", "a.mcap"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->recording.file, "a.mcap");
  EXPECT_TRUE(options->loop);
  EXPECT_TRUE(options->recording.bundles);
  EXPECT_EQ(options->recording.split_bytes, 0u);
  EXPECT_FALSE(options->seconds);
  EXPECT_THROW(Parse({}), UsageError);
}

TEST(RecorderOptions, TakeSplitsInMegabytesAndSeconds) {
  const auto options = Parse({"-o", "a.mcap", "--split-size", "1.5", "--split-time", "60", "--for",
                              "5", "--no-loop", "--no-bundle"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->recording.split_bytes, 1'500'000u);
  EXPECT_EQ(options->recording.split_s, 60.0);
  EXPECT_EQ(options->seconds, 5.0);
  EXPECT_FALSE(options->loop);
  EXPECT_FALSE(options->recording.bundles);
}

TEST(RecorderOptions, AskForInfoOfOneFileOrSeveral) {
  const auto options = Parse({"info", "a.mcap", "b.mcap", "--json", "-"});
  ASSERT_TRUE(options);
  EXPECT_THAT(options->info_files, ElementsAre("a.mcap", "b.mcap"));
  EXPECT_EQ(options->json, "-");
  EXPECT_THROW(Parse({"info"}), UsageError);
}

TEST(RecorderOptions, TakeStationsAndNothingElseForTheirNames) {
  const auto options = Parse({"--station", "anna", "-o", "a.mcap", "--station", "ben"});
  EXPECT_THAT(options->stations, ElementsAre("anna", "ben"));
  EXPECT_THROW(Parse({"-o", "a.mcap", "--station", "a/b"}), UsageError);
}

TEST(RecorderOptions, SayThatARecordingIsNoCsv) {
  for (const char* file : {"a.csv", "a", "mcap", "a.mcap.gz"}) {
    const std::string complaint = test::ComplaintOf(ParseRecorderOptions, {"-o", file});
    EXPECT_THAT(complaint, testing::HasSubstr("ends in .mcap"));
    EXPECT_THAT(complaint, testing::HasSubstr("'palpate-replay export' makes CSV"));
  }
}

TEST(RecorderOptions, RefuseWhatMakesNoSense) {
  EXPECT_THROW(Parse({"-o", "a.mcap", "--split-time", "0"}), UsageError);
  EXPECT_THROW(Parse({"-o", "a.mcap", "--transport", "pigeon"}), UsageError);
}

}  // namespace
}  // namespace palpate
