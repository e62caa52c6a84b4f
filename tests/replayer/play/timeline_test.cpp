#include "client/replayer/play/timeline.h"

#include <optional>

#include <gmock/gmock.h>

#include "client/replayer/play/playhead.h"
#include "common/error.h"
#include "tests/replayer/lesson_recording.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Times before the beginning, within gaps, at marks and between them, and after the end.
std::vector<std::int64_t> Places() {
  std::vector<std::int64_t> places = {-1'000'000, -1};
  for (std::int64_t at_ms = 0; at_ms <= 12'500; at_ms += 250) places.push_back(at_ms * kMs);
  for (const std::int64_t at_ms : {1100, 4001, 5999, 6001, 8501, 9099, 9100, 9501, 11'980}) {
    places.push_back(at_ms * kMs);
    places.push_back(at_ms * kMs - 1);
  }
  for (std::int64_t& place : places) place += kBegin_ns;
  return places;
}

class TimelineTest : public testing::Test {
 protected:
  TimelineTest() {
    LessonWriter lesson;
    FillLesson(lesson);
    lesson.Write({.file = folder_ / "a.mcap"});
    reader_.emplace(std::vector<std::string>{folder_ / "a.mcap"});
    timeline_ = TimelineOf(*reader_);
  }
  static void Tell(const std::vector<const Timeline::State*>& states, Viewer& viewer) {
    for (const Timeline::State* state : states) viewer.Hear(state->type, state->cdr);
  }

  Folder folder_;
  std::optional<RecordingReader> reader_;
  Timeline timeline_;
};

TEST_F(TimelineTest, SpansTheRecording) {
  EXPECT_EQ(timeline_.first_ns(), kBegin_ns);
  EXPECT_EQ(timeline_.last_ns(), kBegin_ns + 11'980 * kMs);
  EXPECT_EQ(timeline_.opening_ns(), kBegin_ns);
  EXPECT_EQ(timeline_.left_out(), 0u);
}

TEST_F(TimelineTest, HoldsAtAnyMomentWhatWhoPlayedUpToItHasBeenTold) {
  for (const std::int64_t place : Places()) {
    SCOPED_TRACE(place - kBegin_ns);
    Viewer sought;
    Tell(RestOf(timeline_.At(place), {}), sought);
    EXPECT_EQ(sought.holds, ViewerWhoPlayedTo(*reader_, place).holds);
  }
}

TEST_F(TimelineTest, LeadsFromAnyMomentToAnyOtherOrSaysThatViewersMustForget) {
  int led = 0, anew = 0;
  for (const std::int64_t from : Places()) {
    const Timeline::Moment told = timeline_.At(from);
    const Viewer there = ViewerWhoPlayedTo(*reader_, from);
    for (const std::int64_t to : Places()) {
      SCOPED_TRACE(std::to_string(from - kBegin_ns) + " to " + std::to_string(to - kBegin_ns));
      const Timeline::Moment wanted = timeline_.At(to);
      const bool leads = LeadsTo(told, wanted);
      ++(leads ? led : anew);
      Viewer viewer = leads ? there : Viewer();
      Tell(RestOf(wanted, leads ? told : Timeline::Moment()), viewer);
      Viewer whole;
      Tell(RestOf(wanted, {}), whole);
      ASSERT_EQ(viewer.holds, whole.holds);
    }
  }
  EXPECT_GT(led, 100);
  EXPECT_GT(anew, 100);
}

std::vector<std::uint64_t> ChangesIn(const Timeline::Moment& moment) {
  std::vector<std::uint64_t> numbers;
  for (const auto& [key, state] : moment.holds) {
    if (state->type == RecordedType::kSolidBlock) numbers.push_back(state->number);
  }
  return numbers;
}

TEST_F(TimelineTest, BringsBackWhatWasCutAndCutsItAgain) {
  const auto at = [&](std::int64_t at_ms) { return timeline_.At(kBegin_ns + at_ms * kMs); };
  const auto changes = [&](std::int64_t at_ms) { return ChangesIn(at(at_ms)); };
  EXPECT_THAT(changes(1000), IsEmpty());
  EXPECT_THAT(changes(1600), ElementsAre(1, 2));
  EXPECT_THAT(changes(4999), ElementsAre(1, 2, 3));
  EXPECT_THAT(changes(5000), IsEmpty()) << "made whole";
  EXPECT_THAT(changes(7000), ElementsAre(4));
  EXPECT_THAT(changes(9000), IsEmpty()) << "another server's";
  EXPECT_THAT(changes(9500), ElementsAre(1));
  const auto leads = [&](std::int64_t from_ms, std::int64_t to_ms) {
    return LeadsTo(at(from_ms), at(to_ms));
  };
  EXPECT_TRUE(leads(1000, 3000));
  EXPECT_TRUE(leads(3900, 3000)) << "back, where nothing was cut between";
  EXPECT_FALSE(leads(3000, 1000)) << "blocks come back";
  EXPECT_TRUE(leads(3000, 6000)) << "the whole scene undoes them";
  EXPECT_FALSE(leads(6000, 3000)) << "a whole scene is never cut by older changes";
  EXPECT_FALSE(leads(8000, 9500)) << "another server";
}

TEST_F(TimelineTest, HoldsTheNewestOfEachBlockOfASolidUntilItIsUndone) {
  {
    RecordingWriter writer({.file = folder_ / "cut.mcap"});
    AddBundle(writer, {1, 2, 3}, kBegin_ns);
    const auto add = [&](std::uint64_t change, std::uint32_t block, std::int64_t at_ms) {
      wire::SolidBlock sample{};
      wire::FromText("cube", sample.scene);
      sample.server_run = 77;
      sample.change = change;
      sample.block = block;
      Add(writer, dds::kSolidBlockTopic, sample, kBegin_ns + at_ms * kMs);
    };
    add(1, 5, 10);
    add(2, 6, 20);
    add(3, 5, 30);
    wire::SceneWhole whole{};
    wire::FromText("cube", whole.scene);
    whole.server_run = 77;
    whole.last_change = 3;
    Add(writer, dds::kSceneWholeTopic, whole, kBegin_ns + 40 * kMs);
    add(4, 6, 50);
    writer.Close("");
  }
  RecordingReader reader({folder_ / "cut.mcap"});
  const Timeline timeline = TimelineOf(reader);
  const auto at = [&](std::int64_t at_ms) { return timeline.At(kBegin_ns + at_ms * kMs); };
  const auto changes = [&](std::int64_t at_ms) { return ChangesIn(at(at_ms)); };
  EXPECT_THAT(changes(25), ElementsAre(1, 2));
  EXPECT_THAT(changes(35), ElementsAre(3, 2));
  EXPECT_THAT(changes(45), IsEmpty());
  EXPECT_THAT(changes(60), ElementsAre(4));
  EXPECT_TRUE(LeadsTo(at(25), at(35)));
  EXPECT_FALSE(LeadsTo(at(35), at(25))) << "a block only loses";
  EXPECT_TRUE(LeadsTo(at(35), at(60)));
}

TEST_F(TimelineTest, RefusesABundleThatIsNotTheOneOfItsHash) {
  {
    RecordingWriter writer({.file = folder_ / "forged.mcap"});
    AddBundle(writer, {1, 2, 3}, kBegin_ns, true);
    writer.Close("");
  }
  RecordingReader reader({folder_ / "forged.mcap"});
  EXPECT_THAT([&] { TimelineOf(reader); },
              testing::ThrowsMessage<Error>(HasSubstr("scene 'cube': its bytes have the hash")));
}

// Takes minutes if each "scene made whole" walks through everything held; the test's time limit
// then ends it.
TEST_F(TimelineTest, HoldsAMomentOfManyStationsAndWholes) {
  constexpr std::uint64_t kMany = 30'000;
  {
    RecordingWriter writer({.file = folder_ / "many.mcap"});
    for (std::uint64_t i = 1; i <= kMany; ++i) {
      Add(writer, dds::kSessionStateTopic, SampleState("hand" + std::to_string(i), i), kBegin_ns);
      wire::SceneWhole whole{};
      wire::FromText("cube", whole.scene);
      whole.server_run = 77;
      whole.last_change = i;
      Add(writer, dds::kSceneWholeTopic, whole, kBegin_ns);
    }
    writer.Close("");
  }
  RecordingReader reader({folder_ / "many.mcap"});
  EXPECT_EQ(TimelineOf(reader).At(kBegin_ns).holds.size(), kMany + 1);
}

TEST_F(TimelineTest, MarksWhatTookPlace) {
  std::vector<std::tuple<std::int64_t, palpate_ReplayMarkKind, std::string>> marks;
  for (const Timeline::Mark& mark : timeline_.marks()) {
    marks.emplace_back((mark.time_ns - kBegin_ns) / kMs, mark.kind, mark.text);
  }
  EXPECT_THAT(marks, ElementsAre(std::tuple(0, palpate_REPLAY_SESSION, "hand takes the ball"),
                                 std::tuple(200, palpate_REPLAY_SESSION, "other takes the ball"),
                                 std::tuple(1500, palpate_REPLAY_CONTACT, "hand touches"),
                                 std::tuple(3200, palpate_REPLAY_FAULT,
                                            "hand: " + FaultWords(kFaultJammed)),
                                 std::tuple(5000, palpate_REPLAY_WHOLE, "cube is whole again"),
                                 std::tuple(9100, palpate_REPLAY_SESSION, "hand takes the ball")));
}

TEST_F(TimelineTest, SaysWhereAStationHasNoToolStatesAndWhy) {
  std::vector<std::tuple<std::int64_t, std::int64_t, std::string, std::string>> gaps;
  for (const Timeline::Gap& gap : timeline_.gaps()) {
    gaps.emplace_back((gap.from_ns - kBegin_ns) / kMs, (gap.to_ns - kBegin_ns) / kMs, gap.station,
                      gap.reason);
  }
  EXPECT_THAT(gaps, ElementsAre(std::tuple(2000, 11'980, "other", "no session: the hand has left"),
                                std::tuple(3980, 6000, "hand",
                                           "tool states were lost; the poses were recorded"),
                                std::tuple(8480, 9200, "hand", "no session: the hand has left")));
}

TEST_F(TimelineTest, KnowsWhoHasBeenSilentForLong) {
  const Timeline::Source hand{RecordedType::kToolState, "hand"};
  const Timeline::Source other{RecordedType::kToolState, "other"};
  const auto quiet = [&](std::int64_t at_ms) { return timeline_.QuietAt(kBegin_ns + at_ms * kMs); };
  const auto at = [](std::int64_t at_ms) { return kBegin_ns + at_ms * kMs; };
  EXPECT_THAT(quiet(-5000), IsEmpty());
  EXPECT_THAT(quiet(3000), IsEmpty());
  EXPECT_THAT(quiet(3900), ElementsAre(std::pair(other, at(2000))));
  EXPECT_THAT(quiet(5900), ElementsAre(std::pair(hand, at(3980)), std::pair(other, at(2000))));
  EXPECT_THAT(quiet(6000), ElementsAre(std::pair(other, at(2000))));
  EXPECT_THAT(quiet(60'000), ElementsAre(std::pair(hand, at(11'980)), std::pair(other, at(2000))));
}

TEST(Timeline, LeavesOutMarksAndGapsThatNoListCouldShow) {
  const Folder folder;
  LessonWriter lesson;
  for (std::int64_t i = 0; i <= 900; ++i) lesson.Tool(2000 * i, "hand", i % 2 == 0 ? 1 : 0);
  lesson.Write({.file = folder / "a.mcap"});
  RecordingReader reader({folder / "a.mcap"});
  const Timeline timeline = TimelineOf(reader);
  EXPECT_EQ(timeline.gaps().size(), Timeline::kMost);
  EXPECT_EQ(timeline.marks().size(), Timeline::kMost);
  EXPECT_EQ(timeline.left_out(), 900 + 451 - 2 * Timeline::kMost);
  EXPECT_THAT(timeline.gaps().front().reason, HasSubstr("nothing at all was recorded"));
}

TEST(Timeline, TakesBytesThatAreNoSampleForNothing) {
  const Folder folder;
  LessonWriter lesson;
  lesson.Tool(0, "hand");
  lesson.Broken(10, dds::kToolStateTopic, RecordedType::kToolState);
  lesson.Broken(20, dds::kSessionStateTopic, RecordedType::kSessionState);
  lesson.Broken(40, dds::kSceneWholeTopic, RecordedType::kSceneWhole);
  lesson.Broken(45, dds::kSolidBlockTopic, RecordedType::kSolidBlock);
  lesson.Broken(50, dds::kSceneBundleTopic, RecordedType::kSceneBundle);
  lesson.Write({.file = folder / "a.mcap"});
  RecordingReader reader({folder / "a.mcap"});
  const Timeline timeline = TimelineOf(reader);
  EXPECT_THAT(timeline.marks(), IsEmpty());
  EXPECT_THAT(timeline.At(timeline.last_ns()).holds, IsEmpty());
  EXPECT_EQ(timeline.last_ns(), kBegin_ns + 50 * kMs);
}

TEST(Timeline, GivesASampleWhoseTimeGoesBackTheTurnOfTheOneBefore) {
  const std::string topic = "t";
  const auto at = [&](std::int64_t time_ns) {
    return RecordedSample{RecordedType::kToolState, &topic, time_ns, {}};
  };
  EXPECT_EQ(Timeline::TurnOf(at(7), 5), 7);
  EXPECT_EQ(Timeline::TurnOf(at(3), 5), 5);
}

TEST(PlaybackClock, GoesWithTheClockTimesARate) {
  PlaybackClock clock(0.5, false);
  clock.Begin(1000, 50);
  EXPECT_EQ(clock.At(50), 1000);
  EXPECT_EQ(clock.At(70), 1010);
}

TEST(PlaybackClock, StandsWhilePausedAndGoesOnFromThere) {
  PlaybackClock clock(2.0, false);
  clock.Begin(1000, 0);
  clock.SetPaused(true, 10);
  EXPECT_TRUE(clock.paused());
  EXPECT_EQ(clock.At(500), 1020);
  clock.SetPaused(false, 500);
  EXPECT_EQ(clock.At(501), 1022);
}

TEST(PlaybackClock, GoesOnFromWhereItIsAtAnotherRate) {
  PlaybackClock clock(1.0, false);
  clock.Begin(1000, 0);
  clock.SetRate(4.0, 10);
  EXPECT_EQ(clock.rate(), 4.0);
  EXPECT_EQ(clock.At(10), 1010);
  EXPECT_EQ(clock.At(20), 1050);
  clock.SetPaused(true, 20);
  clock.SetRate(0.5, 30);
  EXPECT_EQ(clock.At(1000), 1050) << "still paused";
}

using Heard = std::vector<std::pair<std::int64_t, std::vector<std::uint8_t>>>;

/// The parameter is the length of a split [s]; 0: one file.
class PlayheadTest : public testing::TestWithParam<double> {
 protected:
  PlayheadTest() {
    LessonWriter lesson;
    FillLesson(lesson);
    std::vector<std::string> files;
    lesson.Write({.file = folder_ / "a.mcap", .split_s = GetParam()}, &files);
    EXPECT_EQ(files.size() > 1, GetParam() > 0.0);
    reader_.emplace(files);
    timeline_ = TimelineOf(*reader_);
    reader_->Restart();
    RecordedSample sample{};
    while (reader_->Next(sample)) {
      if (!IsForViewers(sample.type)) continue;
      all_.emplace_back(sample.log_time_ns, std::vector(sample.cdr.begin(), sample.cdr.end()));
    }
  }
  Heard AllAfter(std::int64_t time_ns) const {
    Heard rest;
    for (const auto& sample : all_) {
      if (sample.first > time_ns) rest.push_back(sample);
    }
    return rest;
  }

  Folder folder_;
  std::optional<RecordingReader> reader_;
  Timeline timeline_;
  Heard all_;
};

TEST_P(PlayheadTest, ShowsAndGoesOnAsIfItHadPlayedUpToThere) {
  // There and back: no seek depends on the one before.
  for (const std::int64_t at_ms : {0, 11'980, 1500, 5900, 4500, -1, 3000, 8499, 5000, 9000, 8501,
                                   20'000, 2010, 6000, 10'500}) {
    SCOPED_TRACE(at_ms);
    const std::int64_t time_ns = kBegin_ns + at_ms * kMs;
    Playhead again(*reader_, timeline_);
    const Viewer viewer = ViewerWhoPlayedTo(*reader_, time_ns);
    // The reader is left at its end, where it knows all files.
    TimelineOf(*reader_);
    EXPECT_EQ(again.GoTo(time_ns), viewer.streams);
    Heard rest;
    RecordedSample sample{};
    while (again.Next(sample)) {
      EXPECT_EQ(again.passed_ns(), sample.log_time_ns);
      rest.emplace_back(sample.log_time_ns, std::vector(sample.cdr.begin(), sample.cdr.end()));
    }
    EXPECT_EQ(rest, AllAfter(time_ns));
  }
}

INSTANTIATE_TEST_SUITE_P(Files, PlayheadTest, testing::Values(0.0, 3.0));

}  // namespace
}  // namespace palpate::test
