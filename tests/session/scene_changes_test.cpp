#include "server/session/scene_changes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/session/session_table.h"
#include "tests/session/ball_tool.h"
#include "tests/session/crust.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

using testing::IsEmpty;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint64_t kServerRun = 99;

wire::SessionRequest RequestOf(const std::string& station, const std::string& tool) {
  wire::SessionRequest request{};
  wire::FromText(station, request.station);
  request.run = 1;
  wire::FromText("crust", request.scene);
  wire::FromText(tool, request.tool);
  return request;
}

void Leave(SessionTable& table, const std::string& station, const std::string& tool,
           std::int64_t now) {
  wire::SessionRequest leave = RequestOf(station, tool);
  leave.leave = true;
  table.Request(leave, now);
  table.Update(now);
}

class SceneChangesTest : public testing::Test {
 protected:
  void Admit(const std::string& station, const std::string& tool) {
    table_.Request(RequestOf(station, tool), now_);
    hands_[station];
  }
  void AdmitBoth() {
    Admit("a", "left");
    Admit("b", "right");
  }
  wire::Wrench Send(const std::string& station, const Vec3& p) {
    wire::Wrench answer{};
    poses_[station].push_back(hands_[station].At(p));
    table_.sessions().at(station)->loop().OnPose(poses_[station].back(), answer);
    answers_[station].push_back(answer);
    return answer;
  }
  /// Strokes along x at this y, pressed into the floor with up to 2 N.
  void Scrape(const std::vector<std::pair<std::string, double>>& who, int steps) {
    for (int i = 0; i < steps; ++i) {
      for (const auto& [station, y] : who) {
        const auto s = static_cast<double>(strokes_[station]++);
        const double z = s < 500 ? 0.004 - 6e-6 * s : 0.001;
        Send(station, Vec3(0.008 * std::sin(5e-3 * s), y, z));
      }
      table_.Update(now_ += kMs);
      for (const wire::SceneChange& change : table_.TakeSceneChanges()) changes_.push_back(change);
      for (const wire::LeafTaken& taken : table_.TakeLeavesTaken()) taken_.push_back(taken);
    }
  }
  /// Both tools beside one another.
  void ScrapeBoth(int steps) { Scrape({{"a", 0.0}, {"b", 0.0005}}, steps); }
  const ServoLoop& LoopOf(const std::string& station) {
    return table_.sessions().at(station)->loop();
  }

  std::int64_t now_ = 1000 * kMs;
  Scene scene_ = Crust();
  std::vector<std::shared_ptr<const ServedTool>> tools_ = ToolsOf(scene_);
  SessionTable table_{tools_, kServerRun};
  std::map<std::string, Hand> hands_;
  std::map<std::string, int> strokes_;
  std::map<std::string, std::vector<wire::HapticPose>> poses_;
  std::map<std::string, std::vector<wire::Wrench>> answers_;
  std::vector<wire::SceneChange> changes_;
  std::vector<wire::LeafTaken> taken_;
};

TEST_F(SceneChangesTest, SayEachLeafOnceWithItsTrianglesInOneOrder) {
  AdmitBoth();
  ScrapeBoth(4000);
  ASSERT_GT(changes_.size(), 5u);
  std::vector<bool> gone(scene_.objects[0].tree.leaves());
  bool from_a = false, from_b = false;
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    const wire::SceneChange& change = changes_[i];
    EXPECT_EQ(change.change, i + 1);
    EXPECT_EQ(change.server_run, kServerRun);
    EXPECT_STREQ(change.scene, "crust");
    EXPECT_EQ(change.object_index, 0u);
    EXPECT_GT(change.pose_sequence, 0u);
    ASSERT_EQ(change.triangles, 1u);
    EXPECT_EQ(change.triangle[0], change.leaf);
    EXPECT_FALSE(gone[change.leaf]);
    gone[change.leaf] = true;
    from_a |= std::string("a") == change.station;
    from_b |= std::string("b") == change.station;
  }
  EXPECT_TRUE(from_a);
  EXPECT_TRUE(from_b);
}

TEST_F(SceneChangesTest, ReachTheOtherToolsAndThoseThatComeLater) {
  AdmitBoth();
  Scrape({{"a", 0.0}, {"b", 0.01}}, 3000);
  Admit("c", "left");
  Send("b", Vec3(0, 0.01, 0.01));
  const auto in = [](const ServoLoop& loop) {
    std::vector<std::int32_t> leaves;
    for (std::size_t i = 0; i < loop.removals().size(); ++i) {
      leaves.push_back(loop.removals()[i].leaf);
    }
    return leaves;
  };
  std::vector<std::int32_t> changed;
  for (const wire::SceneChange& change : changes_) {
    changed.push_back(static_cast<std::int32_t>(change.leaf));
  }
  EXPECT_THAT(in(LoopOf("b")), testing::UnorderedElementsAreArray(changed));
  // `a` leaves its tool; who takes it up finds the floor as it was left.
  Leave(table_, "a", "left", now_);
  Admit("c", "left");
  Send("c", Vec3(0, 0, 0.01));
  EXPECT_THAT(in(LoopOf("c")), testing::ElementsAreArray(changed));
}

TEST_F(SceneChangesTest, TellBeforeWhichPoseOfEachOtherToolALeafWent) {
  AdmitBoth();
  ScrapeBoth(4000);
  for (const std::string station : {"a", "b"}) {
    std::vector<std::pair<std::uint32_t, std::uint64_t>> told, had;
    for (const wire::LeafTaken& taken : taken_) {
      if (station != taken.station) continue;
      EXPECT_EQ(taken.run, 1u);
      told.emplace_back(taken.leaf, taken.pose_sequence);
      EXPECT_EQ(taken.number, told.size());
    }
    for (std::size_t i = 0; i < LoopOf(station).removals().size(); ++i) {
      const Removal& removal = LoopOf(station).removals()[i];
      if (!removal.own) {
        had.emplace_back(static_cast<std::uint32_t>(removal.leaf), removal.pose_sequence);
      }
    }
    EXPECT_GT(told.size(), 2u);
    EXPECT_EQ(told, had);
  }
}

TEST_F(SceneChangesTest, ReplayFromPosesAndTheRecordToTheSameBits) {
  AdmitBoth();
  ScrapeBoth(4000);
  const ServoLoop& played = LoopOf("b");
  ASSERT_GT(played.removals().size(), 5u);
  bool foreign = false;
  // The record alone, in a loop of its own, with no other tool about.
  ServoLoop loop(tools_[1]->model);
  std::size_t next = 0;
  bool started = false;
  for (std::size_t i = 0; i < poses_["b"].size(); ++i) {
    const wire::HapticPose& pose = poses_["b"][i];
    for (; next < played.removals().size() && !played.removals()[next].own &&
           played.removals()[next].pose_sequence == pose.pose_sequence;
         ++next) {
      loop.Remove(played.removals()[next].leaf);
      foreign = true;
    }
    const wire::Wrench& then = answers_["b"][i];
    // Where the session began: at the pose of its first answer that has started.
    if (!started && (then.faults & kFaultNotStarted) == 0) {
      loop.Start(wire::ToPose(then.graphic_position_m, then.graphic_orientation_wxyz));
      started = true;
    }
    wire::Wrench again{};
    loop.OnPose(pose, again);
    ASSERT_EQ(std::memcmp(again.force_N, then.force_N, sizeof again.force_N), 0) << i;
    ASSERT_EQ(std::memcmp(again.graphic_position_m, then.graphic_position_m,
                          sizeof again.graphic_position_m),
              0)
        << i;
    while (next < played.removals().size() && played.removals()[next].own &&
           played.removals()[next].pose_sequence == pose.pose_sequence) {
      ++next;
    }
  }
  EXPECT_TRUE(foreign);
  ASSERT_EQ(loop.removals().size(), played.removals().size());
  for (std::size_t i = 0; i < next; ++i) {
    EXPECT_EQ(loop.removals()[i].leaf, played.removals()[i].leaf);
    EXPECT_EQ(loop.removals()[i].own, played.removals()[i].own);
    EXPECT_EQ(loop.removals()[i].pose_sequence, played.removals()[i].pose_sequence);
  }
}

TEST_F(SceneChangesTest, TellManyTrianglesInSeveralChanges) {
  Admit("a", "left");
  SceneChanges changes("crust", tools_[0]->whole, {}, kServerRun);
  const Session& session = *table_.sessions().at("a");
  const auto told = changes.Remove(session, {0, true, 7});
  ASSERT_EQ(told.size(), 3u);  // 301 triangles, 128 in each
  std::vector<std::uint32_t> triangles;
  for (const wire::SceneChange& change : told) {
    EXPECT_EQ(change.leaf, 0u);
    EXPECT_EQ(change.pose_sequence, 7u);
    triangles.insert(triangles.end(), change.triangle, change.triangle + change.triangles);
  }
  EXPECT_EQ(triangles.size(), 301u);
  EXPECT_EQ(told.back().change, 3u);
  EXPECT_THAT(changes.Remove(session, {0, true, 8}), IsEmpty());
  EXPECT_THAT(changes.gone(), testing::ElementsAre(0));
}

wire::WholeRequest WholeRequestOf(const std::string& scene) {
  wire::WholeRequest request{};
  wire::FromText(scene, request.scene);
  static std::uint64_t number = 11;
  request.request = ++number;
  wire::FromText("teacher", request.by);
  return request;
}

TEST_F(SceneChangesTest, AreUndoneForAllToolsWhereTheSceneIsMadeWhole) {
  AdmitBoth();
  ScrapeBoth(4000);
  const std::size_t before = changes_.size();
  ASSERT_GT(before, 5u);
  const wire::WholeRequest request = WholeRequestOf("crust");
  table_.Request(request);
  table_.Request(request);  // replayed, or told again by a gateway that is back
  const auto wholes = table_.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_STREQ(wholes[0].scene, "crust");
  EXPECT_STREQ(wholes[0].by, "teacher");
  EXPECT_STREQ(wholes[0].refusal, "");
  EXPECT_EQ(wholes[0].request, request.request);
  EXPECT_EQ(wholes[0].server_run, kServerRun);
  EXPECT_EQ(wholes[0].last_change, before);

  // The same strokes scrape the same leaves off once more, under numbers of their own.
  strokes_.clear();
  ScrapeBoth(4000);
  std::vector<std::uint32_t> first, second;
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    EXPECT_EQ(changes_[i].change, i + 1);
    (i < before ? first : second).push_back(changes_[i].leaf);
  }
  EXPECT_GT(second.size(), 5u);
  std::ranges::sort(first);
  std::ranges::sort(second);
  std::vector<std::uint32_t> both;
  std::ranges::set_intersection(first, second, std::back_inserter(both));
  EXPECT_GT(both.size(), 3u);
}

TEST_F(SceneChangesTest, TellEachLoopsPoseBeforeWhichTheSceneWasWhole) {
  AdmitBoth();
  ScrapeBoth(2000);
  taken_.clear();
  table_.Request(WholeRequestOf("crust"));
  ScrapeBoth(1);
  ASSERT_EQ(taken_.size(), 2u);
  for (const wire::LeafTaken& taken : taken_) {
    EXPECT_EQ(taken.leaf, wire::kNoLeaf);
    EXPECT_EQ(taken.pose_sequence, 2001u);
  }
}

TEST_F(SceneChangesTest, UndoneWhileTheToolIsAmongThemBringItOutAndItsForceBackFromNothing) {
  Admit("a", "left");
  Scrape({{"a", 0.0}}, 8000);  // a groove, through which the tool reaches now
  const Session& session = *table_.sessions().at("a");
  ASSERT_EQ(session.phase(), palpate_SESSION_ACTIVE);
  const Vec3 within(0, 0, 0.0005);
  wire::Wrench answer = Send("a", within);
  ASSERT_LT(answer.graphic_position_m[2], 0.002);
  table_.Request(WholeRequestOf("crust"));
  answer = Send("a", within);
  EXPECT_EQ(wire::ToVec3(answer.force_N).norm(), 0.0);
  EXPECT_NE(answer.faults & kFaultNotStarted, 0u);
  table_.Update(now_ += kMs);
  EXPECT_EQ(session.phase(), palpate_SESSION_ACTIVE);
  EXPECT_EQ(session.start_sequence(), 0u) << "of the start before";
  EXPECT_GT(session.start().p.z(), 0.0029) << "on the floor at 0, with a ball of 3 mm";
  const double first = wire::ToVec3(Send("a", within).force_N).norm();
  table_.Update(now_ += kMs);
  EXPECT_EQ(session.start_sequence(), 8003u);
  for (int i = 0; i < 200; ++i) answer = Send("a", within);
  const double full = wire::ToVec3(answer.force_N).norm();
  EXPECT_GT(full, 2.0);
  EXPECT_LT(first, 0.02 * full);
}

TEST_F(SceneChangesTest, UndoneTwiceBeforeAPoseAreUndoneOnce) {
  Admit("a", "left");
  Scrape({{"a", 0.0}}, 3000);
  taken_.clear();
  table_.Request(WholeRequestOf("crust"));
  table_.Request(WholeRequestOf("crust"));
  EXPECT_EQ(table_.TakeWholes().size(), 2u);
  Scrape({{"a", 0.0}}, 3000);
  EXPECT_EQ(taken_.size(), 1u);
  EXPECT_EQ(table_.sessions().at("a")->phase(), palpate_SESSION_ACTIVE);
}

TEST(SceneChanges, BeginAnewWithASessionWhereTheSceneSaysSo) {
  const Scene scene = Crust();
  SessionTable table(ToolsOf(scene, true), kServerRun);
  Hand hand;
  const auto scrape = [&] {
    table.Request(RequestOf("a", "left"), kMs);
    for (int i = 0; i < 4000; ++i) {
      wire::Wrench answer{};
      const double z = i < 500 ? 0.004 - 6e-6 * i : 0.001;
      table.sessions().at("a")->loop().OnPose(hand.At(Vec3(0.008 * std::sin(5e-3 * i), 0, z)),
                                              answer);
      table.Update(kMs);
    }
    return table.TakeSceneChanges().size();
  };
  ASSERT_GT(scrape(), 5u);
  EXPECT_THAT(table.TakeWholes(), IsEmpty());
  table.Request(RequestOf("b", "right"), kMs);
  EXPECT_THAT(table.TakeWholes(), IsEmpty()) << "a works there";
  Leave(table, "b", "right", kMs);
  // `a` falls silent, and goes on where it was.
  table.Update(1000 * kMs);
  ASSERT_THAT(table.sessions(), IsEmpty());
  table.Request(RequestOf("a", "left"), 1000 * kMs);
  EXPECT_THAT(table.TakeWholes(), IsEmpty()) << "a resumes its session";
  // A station whose endpoints fail leaves, too, and asks anew before its first pose.
  Leave(table, "a", "left", 1000 * kMs);
  table.Request(RequestOf("a", "left"), 1000 * kMs);
  EXPECT_THAT(table.TakeWholes(), IsEmpty()) << "a resumes its session by another transport";
  wire::Wrench answer{};
  table.sessions().at("a")->loop().OnPose(hand.At(Vec3(0, 0, 0.004)), answer);
  table.Update(1000 * kMs);
  Leave(table, "a", "left", 1000 * kMs);
  EXPECT_GT(scrape(), 5u);
  const auto wholes = table.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_STREQ(wholes[0].by, "a");
  EXPECT_EQ(wholes[0].request, 0u);
}

TEST(SceneChanges, CannotBeUndoneWhereNothingWears) {
  SessionTable table({BallTool()}, kServerRun);
  table.Request(WholeRequestOf("ball"));
  const auto wholes = table.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_THAT(wholes[0].refusal, testing::HasSubstr("no tool of the scene cuts"));
  table.Request(WholeRequestOf("another server's"));
  EXPECT_THAT(table.TakeWholes(), IsEmpty());
}

TEST_F(SceneChangesTest, AllocateNothingInTheLoop) {
  Admit("a", "left");
  Scrape({{"a", 0.0}}, 600);
  ServoLoop& loop = table_.sessions().at("a")->loop();
  table_.sessions().at("a")->MakeWhole();
  wire::Wrench whole{};
  const wire::HapticPose next = hands_["a"].At(Vec3(0, 0, 0.004));
  const auto allocations_before = AllocationsOfThisThread();
  loop.OnPose(next, whole);
  EXPECT_EQ(AllocationsOfThisThread(), allocations_before);
  table_.Update(now_ += kMs);  // forces begin again
  table_.sessions().at("a")->Remove(5);
  const std::size_t before = loop.removals().size();
  std::vector<wire::HapticPose> poses;
  for (int i = 600; i < 3000; ++i) {
    poses.push_back(hands_["a"].At(Vec3(0.008 * std::sin(5e-3 * i), 0.0, 0.001)));
  }
  const auto allocations = AllocationsOfThisThread();
  wire::Wrench answer{};
  for (const wire::HapticPose& pose : poses) loop.OnPose(pose, answer);
  EXPECT_EQ(AllocationsOfThisThread(), allocations);
  EXPECT_GT(loop.removals().size(), before + 1);
}

}  // namespace
}  // namespace palpate::test
