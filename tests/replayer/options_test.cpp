#include "client/replayer/options.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/command_line.h"

namespace palpate {
namespace {

using testing::ElementsAre;
void Parse(const std::vector<const char*>& words) {
  test::ParseWith(ParseReplayOptions, words);
}
/// Returns the options of a command; throws std::bad_variant_access if it is another one.
template <class Command>
Command Parse(const std::vector<const char*>& words) {
  return std::get<Command>(test::ParseWith(ParseReplayOptions, words)->command);
}

TEST(ReplayOptions, PlayToViewersUnlessToldOtherwise) {
  const auto options = Parse<PlayCommand>({"a.mcap", "b.mcap"});
  EXPECT_THAT(options.playback.files, ElementsAre("a.mcap", "b.mcap"));
  EXPECT_EQ(options.playback.rate, 1.0);
  EXPECT_FALSE(options.playback.loop);
}

TEST(ReplayOptions, VerifyGuideAndScore) {
  EXPECT_FALSE(Parse<VerifyCommand>({"a.mcap", "--verify"}).key);
  const auto command = Parse<VerifyCommand>({"verify", "a.mcap", "--scene", "cube"});
  EXPECT_THAT(command.files, ElementsAre("a.mcap"));
  EXPECT_EQ(command.verify.scene, "cube");
  EXPECT_EQ(Parse<GuideCommand>({"a.mcap", "--guide", "hand"}).guide.led, "hand");
  const auto score = Parse<ScoreCommand>({"score", "a.mcap", "b.mcap", "--out", "report"});
  EXPECT_EQ(score.score.expert, "a.mcap");
  EXPECT_THAT(score.score.trials, ElementsAre("b.mcap"));
  EXPECT_EQ(score.out, "report");
}

TEST(ReplayOptions, ExportColumnsOrWhatBursLeft) {
  EXPECT_FALSE(Parse<ExportCommand>({"export", "a.mcap", "-o", "out"}).exports_solids);
  const auto solids =
      Parse<ExportCommand>({"export", "a.mcap", "-o", "out", "--solids", "--at", "20"});
  EXPECT_TRUE(solids.exports_solids);
  EXPECT_THAT(solids.solids.files, ElementsAre("a.mcap"));
  EXPECT_EQ(solids.solids.folder, "out");
  EXPECT_EQ(solids.solids.at_s, 20.0);
  EXPECT_THROW(Parse({"export", "a.mcap", "-o", "out", "--at", "20"}), UsageError);
  EXPECT_THROW(Parse({"export", "a.mcap", "-o", "out", "--solids", "--format", "npy"}), UsageError);
}

TEST(ReplayOptions, SayWhoseSessionIsMeant) {
  const auto score =
      Parse<ScoreCommand>({"score", "--station", "anna", "a.mcap", "b.mcap", "c.mcap", "--station",
                           "ben/0000000000000001", "--expert-station", "teacher"});
  EXPECT_THAT(score.score.stations, ElementsAre("anna", "ben/0000000000000001"));
  EXPECT_EQ(score.score.expert_station, "teacher");
  EXPECT_THAT(score.score.trials, ElementsAre("b.mcap", "c.mcap"));
  EXPECT_THROW(Parse({"score", "a.mcap", "b.mcap", "--station", "anna", "--station", "ben"}),
               UsageError);
  EXPECT_EQ(Parse<GuideCommand>({"a.mcap", "--guide", "hand", "--station", "anna"}).guide.station,
            "anna");
  EXPECT_THROW(Parse({"a.mcap", "--station", "anna"}), UsageError);
}

TEST(ReplayOptions, SayWhoSteersAndWhatComesAtTheEnd) {
  const auto plain = Parse<PlayCommand>({"a.mcap"});
  EXPECT_FALSE(plain.play.locked);
  EXPECT_FALSE(plain.play.stays);
  const auto lesson = Parse<PlayCommand>({"a.mcap", "--from", "2.5", "--stay", "--locked"});
  EXPECT_EQ(lesson.playback.from_s, 2.5);
  EXPECT_TRUE(lesson.play.stays);
  EXPECT_TRUE(lesson.play.locked);
  EXPECT_THROW(Parse({"a.mcap", "--stay", "--loop"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--verify", "--locked"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--guide", "hand", "--stay"}), UsageError);
}

TEST(ReplayOptions, RefuseWhatMakesNoSense) {
  EXPECT_THROW(Parse({}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--from", "5", "--to", "4"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--rate", "0"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--verify", "--guide", "hand"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--guide", "no name"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "--json", "-"}), UsageError);
  EXPECT_THROW(Parse({"score", "a.mcap"}), UsageError);
  EXPECT_THROW(Parse({"a.mcap", "score", "b.mcap", "c.mcap"}), UsageError);
}

}  // namespace
}  // namespace palpate
