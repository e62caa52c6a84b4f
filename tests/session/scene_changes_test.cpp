#include "server/session/scene_changes.h"

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

class SceneChangesTest : public testing::Test {
 protected:
  void Admit(const std::string& station, const std::string& tool) {
    table_.Request(RequestOf(station, tool), now_);
    hands_[station];
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
  Admit("a", "left");
  Admit("b", "right");
  Scrape({{"a", 0.0}, {"b", 0.0005}}, 4000);
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
  Admit("a", "left");
  Admit("b", "right");
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
  wire::SessionRequest leave = RequestOf("a", "left");
  leave.leave = true;
  table_.Request(leave, now_);
  table_.Update(now_);
  Admit("c", "left");
  Send("c", Vec3(0, 0, 0.01));
  EXPECT_THAT(in(LoopOf("c")), testing::ElementsAreArray(changed));
}

TEST_F(SceneChangesTest, TellBeforeWhichPoseOfEachOtherToolALeafWent) {
  Admit("a", "left");
  Admit("b", "right");
  Scrape({{"a", 0.0}, {"b", 0.0005}}, 4000);
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
  Admit("a", "left");
  Admit("b", "right");
  Scrape({{"a", 0.0}, {"b", 0.0005}}, 4000);
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
  SceneChanges changes("crust", *tools_[0]->whole, kServerRun);
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

TEST_F(SceneChangesTest, AllocateNothingInTheLoop) {
  Admit("a", "left");
  Scrape({{"a", 0.0}}, 600);
  table_.sessions().at("a")->Remove(5);
  ServoLoop& loop = table_.sessions().at("a")->loop();
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

TEST(SceneChanges, AreNoneWhereRemovalIsNotDeclared) {
  Scene scene = Crust();
  scene.features.removal = false;
  const auto tools = ToolsOf(scene);
  ServoLoop loop(tools[0]->model);
  loop.Start({Vec3(0, 0, 0.01), Quat::Identity()});
  Hand hand;
  wire::Wrench answer{};
  for (int i = 0; i < 3000; ++i)
    loop.OnPose(hand.At(Vec3(0.008 * std::sin(5e-3 * i), 0, 1e-3)), answer);
  EXPECT_EQ(loop.removals().size(), 0u);
  EXPECT_GT(answer.contacts, 0u);
}

}  // namespace
}  // namespace palpate::test
