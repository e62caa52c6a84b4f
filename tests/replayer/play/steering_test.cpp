// What a replay tells viewers about itself and takes from them, over DDS within this process.
#include "client/replayer/play/steering.h"

#include <filesystem>
#include <limits>

#include <gmock/gmock.h>

#include "common/dds/cdr.h"
#include "common/error.h"
#include "tests/replayer/lesson_recording.h"
#include "tests/support/eventually.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const int kDomain = OwnDomain();

class SteeringTest : public testing::Test {
 protected:
  SteeringTest() {
    LessonWriter lesson;
    FillLesson(lesson);
    lesson.Write({.file = file_});
    RecordingReader reader({file_});
    timeline_ = TimelineOf(reader);
  }
  ~SteeringTest() override { dds::FreeContents(contents_); }

  void Begin(bool locked = false) {
    steering_.emplace(service_, file_, timeline_, locked);
    ASSERT_TRUE(Eventually([&] { return wishes_.matched_readers() == 1; }));
    ASSERT_TRUE(Eventually([&] { return TakeContents(); }));
  }
  bool TakeContents() {
    dds::CdrSample raw;
    return told_contents_.Take(raw, contents_);
  }
  std::vector<std::string> Bookmarked() const {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < contents_.marks._length; ++i) {
      const wire::ReplayMark& mark = contents_.marks._buffer[i];
      if (mark.kind == palpate_REPLAY_BOOKMARK) names.push_back(mark.text);
    }
    return names;
  }
  /// Sends a wish; returns its number.
  std::uint64_t Wish(wire::ReplayRequest request) {
    if (request.replay == 0) request.replay = contents_.replay;
    request.kind = request.wish;
    request.request = ++last_;
    EXPECT_TRUE(wishes_.Write(request));
    return last_;
  }
  /// Attends until the wish is answered.  True if the player is to carry it out.
  bool Answered(std::uint64_t number) {
    wire::ReplayRequest taken{};
    bool follows = false;
    EXPECT_TRUE(Eventually([&] {
      while (steering_->Take({}, taken)) {
        follows = follows || taken.request == number;
        steering_->Tell({});
      }
      while (told_.Take(state_)) {
      }
      return state_.request == number;
    }));
    return follows;
  }
  std::string RefusalOf(const wire::ReplayRequest& request) {
    EXPECT_FALSE(Answered(Wish(request)));
    return state_.refusal;
  }

  Folder folder_;
  std::string file_ = folder_ / "lesson.mcap";
  Timeline timeline_;
  dds::Participant service_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::ReplayRequest> wishes_{service_, dds::kReplayRequestTopic, dds::Qos::kSession};
  dds::Reader<wire::ReplayState> told_{service_, dds::kReplayStateTopic, dds::Qos::kSession};
  dds::CdrReader<wire::ReplayContents> told_contents_{service_, dds::kReplayContentsTopic,
                                                      dds::Qos::kSession};
  std::optional<Steering> steering_;
  wire::ReplayContents contents_{};
  wire::ReplayState state_{};
  std::uint64_t last_ = 0;
};

wire::ReplayRequest Request(wire::ReplayWish wish, double value = 0.0,
                            const std::string& text = "") {
  wire::ReplayRequest request{};
  request.wish = wish;
  request.value = value;
  wire::FromText(text, request.text);
  return request;
}

TEST_F(SteeringTest, TellsWhatTheRecordingHolds) {
  Begin();
  EXPECT_STREQ(contents_.recording, "lesson.mcap");
  EXPECT_EQ(contents_.begun_ns, kBegin_ns);
  EXPECT_DOUBLE_EQ(contents_.length_s, 11.98);
  EXPECT_FALSE(contents_.locked);
  ASSERT_EQ(contents_.marks._length, timeline_.marks().size());
  EXPECT_DOUBLE_EQ(contents_.marks._buffer[2].at_s, 1.5);
  EXPECT_STREQ(contents_.marks._buffer[2].text, "hand touches");
  ASSERT_EQ(contents_.gaps._length, 3u);
  EXPECT_DOUBLE_EQ(contents_.gaps._buffer[1].from_s, 3.98);
  EXPECT_DOUBLE_EQ(contents_.gaps._buffer[1].to_s, 6.0);
}

TEST_F(SteeringTest, TellsWhereItIs) {
  Begin();
  steering_->Tell({.at_s = 2.5, .rate = 0.5, .sought = 0.25, .playing = true});
  ASSERT_TRUE(Eventually([&] { return told_.Take(state_); }));
  EXPECT_EQ(state_.replay, contents_.replay);
  EXPECT_EQ(state_.at_s, 2.5);
  EXPECT_EQ(state_.rate, 0.5);
  EXPECT_EQ(state_.sought, 0.25);
  EXPECT_TRUE(state_.playing);
  EXPECT_FALSE(state_.ended);
  EXPECT_STREQ(state_.refusal, "");
}

TEST_F(SteeringTest, GivesWishesOfEveryKindInTheOrderOfTheirWriting) {
  Begin();
  const std::vector<wire::ReplayWish> order = {palpate_REPLAY_SEEK, palpate_REPLAY_PLAY,
                                               palpate_REPLAY_RATE, palpate_REPLAY_PAUSE};
  for (const wire::ReplayWish wish : order) Wish(Request(wish, 1.0));
  std::vector<wire::ReplayWish> taken;
  wire::ReplayRequest request{};
  ASSERT_TRUE(Eventually([&] {
    while (steering_->Take({}, request)) taken.push_back(request.wish);
    return taken.size() == order.size();
  }));
  EXPECT_EQ(taken, order);
  EXPECT_TRUE(steering_->steered());
}

TEST_F(SteeringTest, LeavesToThePlayerTimesThatTheRecordingDoesNotHave) {
  Begin();
  EXPECT_TRUE(Answered(Wish(Request(palpate_REPLAY_SEEK, -1e300))));
  EXPECT_TRUE(Answered(Wish(Request(palpate_REPLAY_SEEK, 1e300))));
  EXPECT_STREQ(state_.refusal, "");
}

TEST_F(SteeringTest, PassesOverWishesOfAnotherReplayAndThoseThatItHasHeard) {
  Begin();
  wire::ReplayRequest others = Request(palpate_REPLAY_PAUSE);
  others.replay = contents_.replay + 1;
  Wish(others);
  // The other replay's wish was written earlier, by the same writer, so it has been heard by now.
  const std::uint64_t own = Wish(Request(palpate_REPLAY_PLAY));
  --last_;
  ASSERT_EQ(Wish(Request(palpate_REPLAY_PLAY)), own);
  const std::uint64_t last = Wish(Request(palpate_REPLAY_PAUSE));
  std::vector<std::uint64_t> taken;
  wire::ReplayRequest request{};
  ASSERT_TRUE(Eventually([&] {
    while (steering_->Take({}, request)) taken.push_back(request.request);
    return !taken.empty() && taken.back() == last;
  }));
  EXPECT_THAT(taken, ElementsAre(own, last));
}

TEST(ReplayRequest, IsNoneWithAWishThatNobodyKnows) {
  std::vector<std::uint8_t> cdr;
  dds::ToCdr(Request(palpate_REPLAY_DROP_BOOKMARK), cdr);
  // It follows the encoding, `kind`, padding, `replay` and `request`.
  const std::size_t wish = 4 + 4 + 4 + 8 + 8;
  wire::ReplayRequest request{};
  ASSERT_EQ(cdr[wish], palpate_REPLAY_DROP_BOOKMARK);
  EXPECT_TRUE(dds::FromCdr(cdr, request));
  cdr[wish] += 1;
  EXPECT_FALSE(dds::FromCdr(cdr, request));
}

TEST_F(SteeringTest, RefusesWhatCannotBeDoneAndSaysWhy) {
  Begin();
  const double nan = std::nan("");
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_SEEK, nan)), HasSubstr("number"));
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_SEEK, std::numeric_limits<double>::infinity())),
              HasSubstr("number"));
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_RATE, nan)), HasSubstr("number"));
  for (const double rate : {0.0, -1.0, 0.05, 8.5, 1e9}) {
    EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_RATE, rate)), HasSubstr("0.1 to 8"));
  }
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_ADD_BOOKMARK, nan, "a")), HasSubstr("number"));
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_ADD_BOOKMARK, 1.0, "")), HasSubstr("name"));
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_ADD_BOOKMARK, 1.0, std::string(120, 'a'))),
              HasSubstr("shorten"));
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_DROP_BOOKMARK, 1.0)), HasSubstr("no longer exists"));
  EXPECT_FALSE(std::filesystem::exists(Bookmarks::FileFor(file_)));
  // A wish that needs no number is not refused for one.
  EXPECT_TRUE(Answered(Wish(Request(palpate_REPLAY_PAUSE, nan))));
  EXPECT_STREQ(state_.refusal, "");
}

TEST_F(SteeringTest, KeepsBookmarksAndTellsOfThem) {
  Begin();
  EXPECT_EQ(RefusalOf(Request(palpate_REPLAY_ADD_BOOKMARK, 3.0, "the groove")), "");
  EXPECT_EQ(RefusalOf(Request(palpate_REPLAY_ADD_BOOKMARK, 1e9, "the end")), "");
  EXPECT_TRUE(Eventually([&] { return TakeContents() && Bookmarked().size() == 2; }));
  EXPECT_THAT(Bookmarked(), ElementsAre("the groove", "the end"));
  const Bookmarks kept(Bookmarks::FileFor(file_));
  ASSERT_EQ(kept.all().size(), 2u);
  EXPECT_DOUBLE_EQ(kept.all()[1].at_s, 11.98);
  EXPECT_THAT(RefusalOf(Request(palpate_REPLAY_DROP_BOOKMARK, 1.5)), HasSubstr("no longer exists"));
  EXPECT_EQ(RefusalOf(Request(palpate_REPLAY_DROP_BOOKMARK, 1.0)), "");
  EXPECT_TRUE(Eventually([&] { return TakeContents() && Bookmarked().size() == 1; }));
  EXPECT_THAT(Bookmarked(), ElementsAre("the end"));
  // The next replay finds the bookmarks.
  steering_.reset();
  Begin();
  EXPECT_THAT(Bookmarked(), ElementsAre("the end"));
}

TEST_F(SteeringTest, RefusesEveryWishWhereItIsLocked) {
  Begin(true);
  EXPECT_TRUE(contents_.locked);
  for (const wire::ReplayWish wish :
       {palpate_REPLAY_PLAY, palpate_REPLAY_PAUSE, palpate_REPLAY_SEEK, palpate_REPLAY_RATE,
        palpate_REPLAY_ADD_BOOKMARK, palpate_REPLAY_DROP_BOOKMARK}) {
    EXPECT_THAT(RefusalOf(Request(wish, 1.0, "a")), HasSubstr("--locked"));
  }
  EXPECT_FALSE(steering_->steered());
  EXPECT_FALSE(std::filesystem::exists(Bookmarks::FileFor(file_)));
  steering_->AddBookmark(2.0, "this terminal's");
  EXPECT_TRUE(std::filesystem::exists(Bookmarks::FileFor(file_)));
}

TEST_F(SteeringTest, FindsTheMarksBesideATime) {
  Begin();
  steering_->AddBookmark(2.0, "mine");
  EXPECT_EQ(steering_->MarkAfter(1.5), 2.0);
  EXPECT_EQ(steering_->MarkBefore(2.0), 1.5);
  EXPECT_EQ(steering_->MarkBefore(0.0), std::nullopt);
  EXPECT_EQ(steering_->MarkAfter(11.0), std::nullopt);
}

TEST_F(SteeringTest, DoesNotBeginBesideABrokenFileOfBookmarks) {
  WriteBytes(Bookmarks::FileFor(file_), {'{', '}'});
  EXPECT_THROW(Steering(service_, file_, timeline_, false), Error);
  EXPECT_EQ(BytesOf(Bookmarks::FileFor(file_)).size(), 2u);
}

}  // namespace
}  // namespace palpate::test
