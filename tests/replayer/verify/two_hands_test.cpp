#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "client/replayer/score/cut_measures.h"
#include "client/replayer/score/trial_cut.h"
#include "client/replayer/verify/verify.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/recording/recording_reader.h"
#include "scenes/files/scene_bundle.h"
#include "server/session/session_table.h"
#include "tests/common/recording/samples.h"
#include "tests/session/block_scene.h"
#include "tests/session/session_request.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/milliseconds.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kServerRun = 99;
const std::vector<std::string> kTwo{"left", "right"};

/// A server without DDS, stations that cut in one groove, and a recorder that hears everything,
/// each topic with a delay of its own.
class Workshop {
 public:
  Workshop(std::uint64_t seed, const std::vector<std::string>& burs)
      : random_(seed), scene_(BlockScene(burs)), table_(ToolsOf(scene_), kServerRun) {
    hands_.resize(burs.size());
    std::vector<std::uint8_t> bundle = PackScene(scene_);
    Hear(dds::kSceneBundleTopic, SampleBundle(bundle, scene_.name, kServerRun));
  }

  void Ask(std::size_t hand) {
    Hand& its = hands_[hand];
    its.run = ++runs_;
    its.sends = true;
    its.sequence = 0;
    table_.Request(RequestOf(hand), now_);
  }
  void Leave(std::size_t hand) {
    hands_[hand].sends = false;
    wire::SessionRequest request = RequestOf(hand);
    request.leave = true;
    table_.Request(request, now_);
  }
  /// Ends a hand without a word.
  void Kill(std::size_t hand) { hands_[hand].sends = false; }
  wire::SceneWhole Whole(wire::WholeWish wish = palpate_WHOLE_AGAIN) {
    wire::WholeRequest request{};
    wire::FromText(scene_.name, request.scene);
    request.request = ++requests_;
    request.wish = wish;
    wire::FromText("lesson", request.by);
    table_.Request(request);
    const wire::SceneWhole answer = table_.TakeWholes().back();
    Hear(dds::kSceneWholeTopic, answer, 1);
    return answer;
  }
  /// Holds the service thread up.
  void Stall(std::int64_t ms) { next_poll_ = now_ + ms * kMs; }
  void Lift(bool lifted) { lifted_ = lifted; }

  void Run(int ms) {
    for (const std::int64_t end = now_ + ms * kMs; now_ < end; now_ += kMs) {
      for (std::size_t hand = 0; hand < hands_.size(); ++hand) Send(hand);
      if (now_ < next_poll_) continue;
      Poll();
      next_poll_ = now_ + (1 + random_.Below(10)) * kMs;
    }
  }
  /// Stops the server.
  void End() {
    links_.clear();
    table_.EndAll("the server stops");
    Publish();
  }

  /// Writes what the recorder heard.
  /// @param keep  returns false for parts of the log to leave out.
  void Write(const std::string& file,
             const std::function<bool(const wire::CutLog&)>& keep = nullptr,
             std::int64_t split_ms = 0, std::vector<std::string>* files = nullptr) {
    std::ranges::stable_sort(heard_, {}, &Heard::time_ns);
    RecordingWriter writer({.file = file, .split_s = 1e-3 * static_cast<double>(split_ms)});
    for (const Heard& one : heard_) {
      const RecordedSample sample{one.type, &one.topic, one.time_ns, one.cdr};
      dds::Owned<wire::CutLog> log;
      if (keep && sample.To(log.value) && !keep(log.value)) continue;
      writer.Add(one.topic, one.type, one.time_ns, one.cdr);
    }
    writer.Close("");
    if (files != nullptr) *files = writer.files();
  }

  Session& session(std::size_t hand) { return *table_.sessions().at(NameOf(hand)); }
  bool is_here(std::size_t hand) { return table_.sessions().contains(NameOf(hand)); }
  double force_N(std::size_t hand) const { return hands_[hand].force_N; }
  Random& random() { return random_; }
  /// By block: whether it is cut, and its surface.
  using Shown = std::map<std::uint32_t, std::pair<bool, std::vector<std::uint8_t>>>;
  const Shown& shown() const { return shown_; }
  std::size_t held() const { return held_; }
  std::size_t merged() const { return merged_; }

 private:
  struct Hand {
    bool sends = false;
    std::uint64_t run = 0, sequence = 0;
    Vec3 at = Vec3(0, 0, 2e-3);
    double force_N = 0.0;
  };
  struct Heard {
    std::int64_t time_ns;
    std::string topic;
    RecordedType type;
    std::vector<std::uint8_t> cdr;
  };

  static std::string NameOf(std::size_t hand) { return "hand" + std::to_string(hand); }
  wire::SessionRequest RequestOf(std::size_t hand) const {
    return MakeRequest(NameOf(hand), hands_[hand].run, scene_.name, scene_.tools[hand].name);
  }

  template <class T>
  void Hear(const std::string& topic, const T& sample, std::int64_t late_ms = 0) {
    std::vector<std::uint8_t> cdr;
    dds::ToCdr(sample, cdr);
    heard_.push_back({now_ + late_ms * kMs, topic, kTypeOf<T>, std::move(cdr)});
  }

  /// Sends a pose along the groove, back and forth at each hand's pace, 0.5 mm deep in the end.
  void Send(std::size_t hand) {
    Hand& its = hands_[hand];
    const auto link = links_.find(NameOf(hand));
    if (!its.sends || link == links_.end() || link->second->run() != its.run) return;
    const double t = 1e-9 * static_cast<double>(now_), i = static_cast<double>(hand);
    const double x = 1.5e-3 * std::sin(2.0 * M_PI * (0.5 + 0.13 * i) * t + i);
    const double down = std::min(1.0, 1e-3 * static_cast<double>(its.sequence) / 0.3);
    const Vec3 to = lifted_ ? Vec3(x, 0, 2e-3) : Vec3(x, 0.1e-3 * i, 1.5e-3 - 2.0e-3 * down);
    const Vec3 way = to - its.at;
    its.at += std::min(1.0, 30e-6 / std::max(way.norm(), 1e-12)) * way;  // 30 mm/s
    wire::HapticPose pose{};
    pose.pose_sequence = ++its.sequence;
    pose.sample_time_ns = now_;
    wire::FromPose({its.at - Vec3(0, kBurRadius, 0), Quat::Identity()}, pose.position_m,
                   pose.orientation_wxyz);
    Hear(dds::PoseTopic(link->first, its.run), pose, random_.Below(4));
    // Of even hands poses get lost, of odd ones wrenches; the recording does not tell which.
    const bool lost = random_.Below(100) == 0;
    if (lost && hand % 2 == 0) return;
    wire::Wrench wrench{};
    const std::uint64_t before = AllocationsOfThisThread();
    const bool is_answered = link->second->loop().OnPose(pose, wrench);
    EXPECT_EQ(AllocationsOfThisThread(), before) << pose.pose_sequence;
    if (!is_answered) return;
    its.force_N = wire::ToWrench(wrench).force.norm();
    // Wrenches are heard in order.
    if (!lost) Hear(dds::WrenchTopic(link->first, its.run), wrench, 2);
  }

  void Poll() {
    table_.Update(now_);
    std::erase_if(links_, [&](const auto& link) {
      const auto session = table_.sessions().find(link.first);
      return session == table_.sessions().end() || session->second != link.second;
    });
    table_.RetireEnded(now_);
    for (const auto& [name, session] : table_.sessions()) {
      if (links_.contains(name)) continue;
      table_.Begin(*session);
      links_[name] = session;
    }
    Publish();
  }
  void Publish() {
    for (const auto& state : table_.TakeChanges()) Hear(dds::kSessionStateTopic, state);
    for (const auto& whole : table_.TakeLoopWholes()) Hear(dds::kLoopWholeTopic, whole, 1);
    for (CutLogNews& news : table_.TakeCutLogs(now_)) {
      for (const wire::CutEvent& event : news.events) {
        held_ += event.step == palpate_CUT_HELD;
        merged_ += event.step == palpate_CUT_MERGED ? event.count : 0;
      }
      news.sample.events._buffer = news.events.data();
      news.sample.events._length = static_cast<std::uint32_t>(news.events.size());
      Hear(dds::kCutLogTopic, news.sample, random_.Below(20));
    }
    for (SolidBlockNews& news : table_.TakeCuts(now_)) {
      news.sample.surface._buffer = news.surface.data();
      news.sample.surface._length = static_cast<std::uint32_t>(news.surface.size());
      Hear(dds::kSolidBlockTopic, news.sample, 1);
      shown_[news.sample.block] = {news.sample.cut, news.surface};
    }
  }

  Random random_;
  Scene scene_;
  SessionTable table_;
  std::map<std::string, std::shared_ptr<Session>> links_;
  std::vector<Hand> hands_;
  std::vector<Heard> heard_;
  std::int64_t now_ = 1000 * kMs, next_poll_ = 0;
  std::uint64_t runs_ = 0, requests_ = 0;
  std::size_t held_ = 0, merged_ = 0;
  Shown shown_;
  bool lifted_ = false;
};

void ExpectSameBits(const CutField& one, const CutField& other) {
  const Lattice& lattice = one.field().lattice();
  std::size_t cut = 0;
  for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
    for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
      for (int i = 0; i < 8 * lattice.blocks[0]; ++i) {
        ASSERT_EQ(one.field().At(i, j, k), other.field().At(i, j, k));
        cut += one.field().At(i, j, k) > 0.0f;
      }
    }
  }
  EXPECT_GT(cut, 1000u);
}

Verification ExpectVerified(const std::vector<std::string>& files) {
  Verification verification = Verify(files, {});
  EXPECT_TRUE(verification.good()) << ToText(verification);
  return verification;
}

class TwoHands : public testing::TestWithParam<std::uint64_t> {
 protected:
  Folder folder_;
  std::string file_ = folder_ / "hands.mcap";
};

TEST_F(TwoHands, FeelEachOthersCutsAndInTheEndTheSame) {
  Workshop workshop(1, kTwo);
  workshop.Ask(0);
  workshop.Run(2500);
  const double alone_N = workshop.force_N(0);
  workshop.Lift(true);
  workshop.Run(200);
  // The other hand meets what is left: its strokes are free where the first has been.
  workshop.Lift(false);
  workshop.Ask(1);
  workshop.Run(1000);
  EXPECT_LT(workshop.force_N(1), alone_N);
  workshop.Lift(true);
  workshop.Run(300);
  ExpectSameBits(workshop.session(0).loop().cuts()[0], workshop.session(1).loop().cuts()[0]);
  EXPECT_GT(workshop.merged(), 100u);
  // What one hand removed is not counted as the other's work.
  const auto left = [&](std::size_t hand) {
    return 1e9 * workshop.session(hand).loop().cuts()[0].VolumeLeft()[0];
  };
  EXPECT_NEAR(left(0), left(1), 0.01);
}

// Hands come, leave and are killed, the scene is made whole, the service thread stalls: verified,
// every wrench of every session has the same bits.
TEST_P(TwoHands, AreTheSameBitsAgainWhateverComesBetween) {
  Workshop workshop(GetParam(), {"left", "right", "late"});
  Random& random = workshop.random();
  for (std::size_t hand = 0; hand < 2; ++hand) workshop.Ask(hand);
  for (int round = 0; round < 9; ++round) {
    workshop.Run(100 + random.Below(200));
    const auto hand = static_cast<std::size_t>(random.Below(3));
    switch (random.Below(8)) {
      case 0:
        workshop.Whole();
        if (random.Below(2) == 0) workshop.Whole();
        break;
      case 6:
        workshop.Whole(palpate_WHOLE_BOOKMARK);
        break;
      case 7:
        workshop.Whole(palpate_WHOLE_BACK);
        if (random.Below(2) == 0) workshop.Whole(palpate_WHOLE_BACK);
        break;
      case 1:
        workshop.Stall(100 + random.Below(150));
        break;
      case 2:
        if (workshop.is_here(hand)) workshop.Leave(hand);
        break;
      case 3:
        if (workshop.is_here(hand)) workshop.Kill(hand);
        break;
      default:
        if (workshop.is_here(hand)) break;
        workshop.Ask(hand);
        // Before or after it has begun.
        workshop.Run(random.Below(3));
        if (random.Below(4) == 0) workshop.Whole(palpate_WHOLE_BACK);
        if (random.Below(4) == 0) workshop.Whole();
        break;
    }
  }
  if (GetParam() % 2 == 0) workshop.End();  // else the recorder ends first
  std::vector<std::string> files;
  workshop.Write(file_, nullptr, 700, &files);
  EXPECT_GT(files.size(), 2u);
  EXPECT_GT(workshop.merged(), 100u);
  const Verification verification = ExpectVerified(files);
  EXPECT_GE(verification.sessions.size(), 2u);
  // The path of one tool alone tells what it cut, or that others cut too.
  const std::string whole = folder_ / "whole.mcap";
  workshop.Write(whole);
  for (const SessionVerdict& session : verification.sessions) {
    HandPath hand;
    hand.station = session.station;
    hand.run = session.run;
    hand.tool_name = session.tool;
    const auto swept = SweptIn(whole, hand, SceneIn(whole, session.scene));
    if (!swept) continue;
    const VerifyOptions options{.whose = {{session.station, session.run}}};
    for (const SessionVerdict& again : Verify({whole}, options).sessions) {
      if (!again.cut) continue;
      EXPECT_EQ(TissuesOf(*swept)[0].after_mm3, TissuesOf(*again.cut)[0].after_mm3);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, TwoHands, testing::Range<std::uint64_t>(1, 5));

TEST_F(TwoHands, ALoopWithoutRoomTellsLaterAndIsTheSameAgain) {
  Workshop workshop(3, kTwo);
  workshop.Ask(0);
  workshop.Ask(1);
  for (int i = 0; i < 4; ++i) {
    workshop.Run(400);
    workshop.Stall(200);
  }
  workshop.Run(300);
  workshop.End();
  EXPECT_GT(workshop.held(), 2u);
  workshop.Write(file_);
  ExpectVerified({file_});
}

TEST_F(TwoHands, GoBackToABookmarkWhichIsFeltShownAndTheSameAgain) {
  Workshop workshop(7, kTwo);
  EXPECT_THAT(workshop.Whole(palpate_WHOLE_BACK).refusal, HasSubstr("no bookmark"));
  workshop.Ask(0);
  workshop.Ask(1);
  workshop.Run(400);
  workshop.Lift(true);
  workshop.Run(200);
  EXPECT_TRUE(workshop.Whole(palpate_WHOLE_BOOKMARK).has_bookmark);
  const CutField then = workshop.session(0).loop().cuts()[0];
  workshop.Run(2500);  // until all is told: what a viewer costs is bounded
  const auto shown_then = workshop.shown();
  workshop.Lift(false);
  workshop.Run(800);
  EXPECT_LT(workshop.session(0).loop().cuts()[0].VolumeLeft()[0], 0.99 * then.VolumeLeft()[0]);
  workshop.Lift(true);
  workshop.Run(200);
  EXPECT_STREQ(workshop.Whole(palpate_WHOLE_BACK).refusal, "");
  workshop.Run(400);
  for (std::size_t hand = 0; hand < 2; ++hand) {
    EXPECT_EQ(workshop.session(hand).phase(), palpate_SESSION_ACTIVE);
    ExpectSameBits(workshop.session(hand).loop().cuts()[0], then);
  }
  // Viewers see what they saw then, and elsewhere the mesh.
  workshop.Run(3000);
  std::size_t whole_again = 0;
  for (const auto& [block, surface] : workshop.shown()) {
    const auto before = shown_then.find(block);
    // A block without a surface now that had none then was not told of then.
    EXPECT_EQ(surface.second,
              before != shown_then.end() ? before->second.second : std::vector<std::uint8_t>(6, 0))
        << block;
    EXPECT_TRUE(before == shown_then.end() || surface.first == before->second.first) << block;
    whole_again += before == shown_then.end() && !surface.first;
  }
  EXPECT_GT(whole_again, 2u);
  workshop.Lift(false);
  workshop.Run(300);
  workshop.End();
  workshop.Write(file_);
  ExpectVerified({file_});
  const std::vector<Restoration> told = Verify({file_}, {}).restorations;
  ASSERT_EQ(told.size(), 2u) << "and not what was refused before anybody worked";
  EXPECT_EQ(told[0].by, "lesson");
  EXPECT_EQ(told[0].wish, palpate_WHOLE_BOOKMARK);
  EXPECT_EQ(told[1].wish, palpate_WHOLE_BACK);
  EXPECT_GT(told[1].time_s, told[0].time_s + 3.0);
}

TEST_F(TwoHands, ARecordingThatLacksAPartOfTheLogSaysSoAndGuessesNothing) {
  Workshop workshop(5, kTwo);
  workshop.Ask(0);
  workshop.Ask(1);
  workshop.Run(1500);
  workshop.End();
  std::uint64_t last = 0;
  workshop.Write(file_, [&](const wire::CutLog& log) {
    last = std::max(last, log.number);
    return log.number != 60;
  });
  EXPECT_GT(last, 80u);
  const Verification verification = Verify({file_}, {});
  EXPECT_FALSE(verification.good());
  for (const SessionVerdict& session : verification.sessions) {
    EXPECT_EQ(session.different, 0u);
    EXPECT_GT(session.verified, 100u);
    EXPECT_THAT(session.ends, HasSubstr("log of what burs cut"));
  }
  // Nor if it began later than the cutting.
  const std::string late = folder_ / "late.mcap";
  workshop.Write(late, [&](const wire::CutLog& log) { return log.number > 60; });
  EXPECT_FALSE(Verify({late}, {}).good());
}

}  // namespace
}  // namespace palpate::test
