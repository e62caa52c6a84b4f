#include "client/recorder/file_summary.h"

#include <functional>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

class FileSummaryTest : public testing::Test {
 protected:
  /// Records a second of a station without the poses in [hole_begin, hole_end); if there are any,
  /// three more are noted as dropped.
  void Record(const std::string& file, std::uint64_t hole_begin, std::uint64_t hole_end) {
    RecordingWriter writer({.file = file, .overwrite = true});
    AddBundle(writer, {1, 2, 3}, kMs);
    wire::SessionState refused = SampleState("other", 8);
    refused.phase = palpate_SESSION_REFUSED;
    Add(writer, dds::kSessionStateTopic, refused, kMs);
    Add(writer, dds::kSessionStateTopic, SampleState("hand", 5), kMs);
    for (std::uint64_t i = 1; i <= 1001; ++i) {
      if (i >= hole_begin && i < hole_end) continue;
      Add(writer, dds::PoseTopic("hand", 5), SamplePose(i), static_cast<std::int64_t>(i) * kMs);
    }
    if (hole_end > hole_begin) {
      writer.SetDropped(dds::PoseTopic("hand", 5), RecordedType::kHapticPose, 3);
    }
    writer.Close("the test is over");
  }

  /// The summary of a recording filled by `put`.
  FileSummary Of(const std::function<void(RecordingWriter&)>& put) {
    RecordingWriter writer({.file = file_});
    put(writer);
    writer.Close("");
    return Summarise({file_});
  }

  Folder folder_;
  std::string file_ = folder_ / "a.mcap";
};

TEST_F(FileSummaryTest, TellsWhatIsInARecording) {
  Record(file_, 0, 0);
  const FileSummary summary = Summarise({file_});
  EXPECT_TRUE(summary.complete);
  EXPECT_EQ(summary.messages, 1004u);
  EXPECT_EQ(summary.missing, 0u);
  EXPECT_NEAR(summary.duration_s, 1.0, 1e-9);
  EXPECT_EQ(summary.build, PALPATE_VERSION);
  EXPECT_EQ(summary.scenes.at("cube").hash, "ebce9b7632ae733b") << "XXH3 of 1, 2, 3";
  ASSERT_THAT(summary.sessions, SizeIs(1)) << "who was refused had none";
  EXPECT_EQ(summary.sessions[0].start_sequence, 3u);
  const FileSummary::Topic& poses = summary.topics.at(dds::PoseTopic("hand", 5));
  EXPECT_EQ(poses.messages, 1001u);
  EXPECT_NEAR(poses.rate_hz, 1000.0, 1e-6);
  EXPECT_THAT(ToText(summary), HasSubstr("nothing is missing"));
}

TEST_F(FileSummaryTest, GivesOneVerdict) {
  Record(file_, 0, 0);
  const std::vector<std::uint8_t> bytes = BytesOf(file_);
  const auto judge = [&](const std::string& verdict, const std::string& head, bool intact) {
    const FileSummary summary = Summarise({file_});
    EXPECT_EQ(summary.verdict(), verdict);
    EXPECT_EQ(summary.whole(), verdict == "whole");
    EXPECT_EQ(summary.intact(), intact);
    EXPECT_THAT(ToText(summary), testing::StartsWith(file_ + ": " + head + "\n"));
  };
  judge("whole", "whole", true);
  // The change is in the header, before all chunks: these are whole, and the file has its end.
  std::vector<std::uint8_t> changed = bytes;
  changed[30] ^= 1;
  WriteBytes(file_, changed);
  judge("damaged", "DAMAGED", false);
  WriteBytes(file_, {bytes.begin(), bytes.end() - 20});
  judge("cut off", "CUT OFF", false);
  std::filesystem::remove(file_);
  Record(file_, 100, 110);
  judge("incomplete", "incomplete", true);
  std::filesystem::remove(file_);
  EXPECT_THROW(Summarise({file_}), Error);
}

TEST_F(FileSummaryTest, NeverClaimsThatMoreIsMissingThanThereCouldBe) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    for (const std::uint64_t i : {std::uint64_t{1}, ~std::uint64_t{0}, std::uint64_t{2}}) {
      Add(writer, dds::PoseTopic("hand", 5), SamplePose(i), kMs);
    }
    writer.SetDropped("a", RecordedType::kHapticPose, ~std::uint64_t{0});
  });
  EXPECT_EQ(summary.missing, 0u);
  EXPECT_EQ(summary.astray, 1u);
  EXPECT_EQ(summary.dropped, 0u);
  EXPECT_EQ(summary.verdict(), std::string("damaged"));
  EXPECT_THAT(ToText(summary), HasSubstr("1 samples have numbers that do not go on from those"));
  EXPECT_THAT(ToText(summary),
              HasSubstr("its recorder's figure is no count: dropped '18446744073709551615'"));
}

TEST_F(FileSummaryTest, TellsWhatIsMissing) {
  Record(file_, 100, 110);
  const FileSummary summary = Summarise({file_});
  EXPECT_EQ(summary.missing, 10u);
  EXPECT_EQ(summary.dropped, 3u);
  EXPECT_EQ(summary.topics.at(dds::PoseTopic("hand", 5)).sequence.holes(), 1u);
  EXPECT_THAT(ToText(summary), HasSubstr("10 samples are missing"));
  WriteJson(summary, folder_ / "a.json");
  const auto bytes = BytesOf(folder_ / "a.json");
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
  EXPECT_EQ(json["missing"], 10);
  EXPECT_EQ(json["topics"].size(), 3u);
}

TEST_F(FileSummaryTest, CountsWhatIsNotOfItsType) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    writer.Add(dds::kSessionStateTopic, RecordedType::kSessionState, kMs,
               std::vector<std::uint8_t>{0, 1, 0, 0, 9});
  });
  EXPECT_EQ(summary.topics.at(dds::kSessionStateTopic).broken, 1u);
  EXPECT_THAT(ToText(summary), Not(HasSubstr("nothing is missing")));
}

TEST_F(FileSummaryTest, TellsThatItsBeginningIsMissing) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    wire::Wrench wrench = SampleWrench(40);
    wrench.answer = 36;
    Add(writer, dds::WrenchTopic("hand", 5), wrench, kMs);
  });
  EXPECT_EQ(summary.missing, 0u) << "they may be in the split before";
  EXPECT_EQ(summary.topics.at(dds::WrenchTopic("hand", 5)).before(), 35u);
  EXPECT_THAT(ToText(summary), HasSubstr("begins with answer 36"));
  EXPECT_THAT(ToText(summary), Not(HasSubstr("nothing is missing")));
}

TEST_F(FileSummaryTest, TellsOfATopicAllOfWhichWasDropped) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    writer.SetDropped(dds::kSceneBundleTopic, RecordedType::kSceneBundle, 2);
  });
  EXPECT_EQ(summary.dropped, 2u);
  EXPECT_FALSE(summary.whole());
}

TEST_F(FileSummaryTest, CountsOnlyWhatWasThere) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    // A server tells late readers of all former sessions at once.
    Add(writer, dds::kSessionStateTopic, SampleState("gone", 4), kMs);
    Add(writer, dds::kSessionStateTopic, SampleState("hand", 5), kMs + 538);
    Add(writer, dds::PoseTopic("hand", 5), SamplePose(1), 2 * kMs);
    Add(writer, dds::PoseTopic("hand", 5), SamplePose(2), 3 * kMs);
  });
  EXPECT_EQ(summary.topics.at(dds::kSessionStateTopic).rate_hz, 0.0);
  EXPECT_NEAR(summary.topics.at(dds::PoseTopic("hand", 5)).rate_hz, 1000.0, 1e-6);
  ASSERT_THAT(summary.sessions, SizeIs(2));
  EXPECT_EQ(summary.sessions[0].poses, 0u);
  EXPECT_EQ(summary.sessions[1].poses, 2u);
  const std::string text = ToText(summary);
  EXPECT_THAT(text, HasSubstr("  station hand (run"));
  EXPECT_THAT(text, Not(HasSubstr("  station gone")));
  EXPECT_THAT(text, HasSubstr("1 session sent no poses during the recording"));
}

TEST_F(FileSummaryTest, TellsOfForcesWhoseStartWasNotToldBeforeTheEnd) {
  const auto put = [](bool begin) {
    return [begin](RecordingWriter& writer) {
      wire::SessionState state = SampleState("hand", 5);
      state.start_sequence = 0;
      Add(writer, dds::kSessionStateTopic, state, kMs);
      for (std::uint64_t i = 1; i <= 9; ++i) {
        wire::Wrench wrench = SampleWrench(i);
        wrench.pose_sequence = i;
        wrench.faults = begin && i >= 7 ? kFaultNone : kFaultNotStarted;
        Add(writer, dds::PoseTopic("hand", 5), SamplePose(i), static_cast<std::int64_t>(i) * kMs);
        Add(writer, dds::WrenchTopic("hand", 5), wrench, static_cast<std::int64_t>(i) * kMs);
      }
    };
  };
  EXPECT_THAT(ToText(Of(put(true))), HasSubstr("forces from pose 7"));
  std::filesystem::remove(file_);
  EXPECT_THAT(ToText(Of(put(false))), HasSubstr("no forces"));
}

TEST_F(FileSummaryTest, TellsThatABundleIsNotTheOneOfItsHash) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    AddBundle(writer, {1, 2, 3}, kMs, true);
  });
  EXPECT_FALSE(summary.whole());
  EXPECT_THAT(ToText(summary), HasSubstr("scene 'cube': its bytes have the hash"));
}

TEST_F(FileSummaryTest, TellsOfTopicsThatTheFileHadNoRoomFor) {
  const FileSummary summary = Of([](RecordingWriter& writer) {
    for (std::uint64_t i = 1; i <= 65'540; ++i) {
      Add(writer, dds::PoseTopic("hand", i), SamplePose(1), kMs);
    }
  });
  EXPECT_TRUE(summary.complete);
  EXPECT_FALSE(summary.whole());
  EXPECT_EQ(summary.no_channel, 5u);
  EXPECT_THAT(ToText(summary), HasSubstr("5 samples came and were left out"));
}

// Takes minutes if each state is searched for among all sessions; the test's time limit then ends
// it.
TEST_F(FileSummaryTest, TellsOfManySessionsInTheOrderInWhichTheyCame) {
  constexpr std::uint64_t kSessions = 60'000;
  const FileSummary summary = Of([](RecordingWriter& writer) {
    for (std::uint64_t i = 1; i <= kSessions; ++i) {
      Add(writer, dds::kSessionStateTopic, SampleState("hand", i), kMs);
    }
  });
  ASSERT_THAT(summary.sessions, SizeIs(kSessions));
  EXPECT_EQ(summary.sessions.front().run, 1u);
  EXPECT_EQ(summary.sessions.back().run, kSessions);
}

TEST_F(FileSummaryTest, QuotesNamesThatPretendToBeALine) {
  const std::string text = ToText(Of([](RecordingWriter& writer) {
    Add(writer, dds::kSessionStateTopic, SampleState("a\n  nothing is missing\x1b[2K", 5), kMs);
    Add(writer, dds::PoseTopic("a\n  nothing is missing\x1b[2K", 5), SamplePose(1), kMs);
  }));
  EXPECT_THAT(text, HasSubstr(R"(station a\n  nothing is missing\x1b[2K)"));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace palpate::test
