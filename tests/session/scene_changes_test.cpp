#include "server/session/scene_changes.h"

#include <map>

#include <gmock/gmock.h>

#include "server/session/session_table.h"
#include "tests/session/ball_tool.h"
#include "tests/session/block_scene.h"
#include "tests/session/session_request.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

using testing::IsEmpty;

wire::WholeRequest WholeRequestOf(const std::string& scene) {
  wire::WholeRequest request{};
  wire::FromText(scene, request.scene);
  static std::uint64_t number = 11;
  request.request = ++number;
  wire::FromText("teacher", request.by);
  return request;
}

class SceneChangesTest : public testing::Test {
 protected:
  explicit SceneChangesTest(bool whole_at_start = false)
      : table_(Tools(whole_at_start), kServerRun) {}
  static std::vector<std::shared_ptr<const ServedTool>> Tools(bool whole_at_start) {
    auto tools = BlockTools();
    for (auto& tool : tools) {
      ServedTool changed = *tool;
      changed.whole_at_start = whole_at_start;
      tool = std::make_shared<const ServedTool>(std::move(changed));
    }
    return tools;
  }
  void Ask(const std::string& station, const std::string& tool, bool leave = false) {
    table_.Request(MakeRequest(station, 1, "block", tool, leave), now_);
    table_.RetireEnded(now_);
    if (!leave) table_.Begin(*table_.sessions().at(station));
  }
  void Leave(const std::string& station, const std::string& tool) {
    Ask(station, tool, true);
    table_.Update(now_);
  }
  /// Sends a pose with the bur's middle at height `z` over the block's face.
  wire::Wrench Send(const std::string& station, double z) {
    wire::Wrench answer{};
    const double x = station == "a" ? -1e-3 : 1e-3;
    table_.sessions().at(station)->loop().OnPose(hands_[station].At(Vec3(x, -kBurRadius, z)),
                                                 answer);
    return answer;
  }
  /// Brings the burs of all stations down into the block, for `milliseconds`.
  void Cut(int milliseconds) {
    for (int ms = 1; ms <= milliseconds; ++ms) {
      for (const auto& [station, session] : table_.sessions()) {
        const auto s = static_cast<double>(++strokes_[station]);
        Send(station, std::max(-kDeep, 1e-3 - 4e-6 * s));
      }
      table_.Update(now_ += kMs);
      for (const wire::LoopWhole& whole : table_.TakeLoopWholes()) wholes_.push_back(whole);
    }
  }
  bool IsCut(const std::string& station) {
    return table_.sessions().at(station)->loop().cuts()[0].VolumeLeft()[0] <
           0.99 * 36e-9;  // a block of 6 x 3 x 2 mm
  }

  static constexpr double kDeep = 0.5e-3;
  std::int64_t now_ = 1000 * kMs;
  SessionTable table_;
  std::map<std::string, Hand> hands_;
  std::map<std::string, int> strokes_;
  std::vector<wire::LoopWhole> wholes_;
};

TEST_F(SceneChangesTest, AreUndoneForAllToolsWhereTheSceneIsMadeWhole) {
  Ask("a", "bur");
  Ask("b", "other");
  Cut(800);
  ASSERT_TRUE(IsCut("a") && IsCut("b"));
  const wire::WholeRequest request = WholeRequestOf("block");
  table_.Request(request);
  table_.Request(request);  // replayed, or told again by a gateway that is back
  const auto wholes = table_.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_STREQ(wholes[0].scene, "block");
  EXPECT_STREQ(wholes[0].by, "teacher");
  EXPECT_STREQ(wholes[0].refusal, "");
  EXPECT_EQ(wholes[0].request, request.request);
  EXPECT_EQ(wholes[0].server_run, kServerRun);
  Cut(1);
  EXPECT_FALSE(IsCut("a") || IsCut("b"));
  ASSERT_EQ(wholes_.size(), 2u);
  for (const wire::LoopWhole& whole : wholes_) {
    EXPECT_STREQ(whole.station, &whole == &wholes_[0] ? "a" : "b");
    EXPECT_EQ(whole.run, 1u);
    EXPECT_EQ(whole.number, 1u);
    EXPECT_EQ(whole.pose_sequence, 801u);
  }
}

TEST_F(SceneChangesTest, UndoneWhileTheToolIsAmongThemBringItOutAndItsForceBackFromNothing) {
  Ask("a", "bur");
  Cut(1500);
  const Session& session = *table_.sessions().at("a");
  ASSERT_EQ(session.phase(), palpate_SESSION_ACTIVE);
  wire::Wrench answer = Send("a", -kDeep);
  ASSERT_LT(answer.graphic_position_m[2], -0.2e-3);
  table_.Request(WholeRequestOf("block"));
  answer = Send("a", -kDeep);
  EXPECT_EQ(wire::ToVec3(answer.force_N).norm(), 0.0);
  EXPECT_NE(answer.faults & kFaultNotStarted, 0u);
  table_.Update(now_ += kMs);
  EXPECT_EQ(session.phase(), palpate_SESSION_ACTIVE);
  EXPECT_EQ(session.start_sequence(), 0u) << "of the start before";
  EXPECT_GT(session.start().p.z(), 0.95 * kBurRadius) << "on the block's face";
  table_.Update(now_ += kMs);
  const double first = wire::ToVec3(Send("a", -kDeep).force_N).norm();
  table_.Update(now_ += kMs);
  EXPECT_EQ(session.start_sequence(), 1503u);
  for (int i = 0; i < 200; ++i) answer = Send("a", -kDeep);
  const double full = wire::ToVec3(answer.force_N).norm();
  EXPECT_GT(full, 0.1);
  EXPECT_LT(first, 0.1 * full);
}

TEST_F(SceneChangesTest, UndoneTwiceBeforeAPoseAreUndoneOnce) {
  Ask("a", "bur");
  Cut(800);
  table_.Request(WholeRequestOf("block"));
  table_.Request(WholeRequestOf("block"));
  EXPECT_EQ(table_.TakeWholes().size(), 2u);
  Cut(800);
  EXPECT_EQ(wholes_.size(), 1u);
  EXPECT_EQ(table_.sessions().at("a")->phase(), palpate_SESSION_ACTIVE);
}

class SceneThatBeginsWhole : public SceneChangesTest {
 protected:
  SceneThatBeginsWhole() : SceneChangesTest(true) {}
};

TEST_F(SceneThatBeginsWhole, DoesSoWithASessionWhereNobodyElseWorks) {
  Ask("a", "bur");
  Cut(800);
  ASSERT_TRUE(IsCut("a"));
  Ask("b", "other");
  EXPECT_THAT(table_.TakeWholes(), IsEmpty()) << "a works there";
  Leave("b", "other");
  // `a` falls silent, and comes back to where it was.
  table_.Update(now_ += 1000 * kMs);
  ASSERT_THAT(table_.sessions(), IsEmpty());
  Ask("a", "bur");
  EXPECT_THAT(table_.TakeWholes(), IsEmpty()) << "a resumes its session";
  // A station whose endpoints fail leaves as well, and asks again before its first pose.
  Leave("a", "bur");
  Ask("a", "bur");
  EXPECT_THAT(table_.TakeWholes(), IsEmpty()) << "a resumes its session by another transport";
  Send("a", 1e-3);
  table_.Update(now_);
  Leave("a", "bur");
  Ask("a", "bur");
  const auto wholes = table_.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_STREQ(wholes[0].by, "a");
  EXPECT_EQ(wholes[0].request, 0u);
  EXPECT_FALSE(IsCut("a"));
}

TEST(SceneChanges, CannotBeUndoneWhereNothingIsCut) {
  SessionTable table({BallTool()}, kServerRun);
  table.Request(WholeRequestOf("ball"));
  const auto wholes = table.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_THAT(wholes[0].refusal, testing::HasSubstr("no tool of the scene cuts"));
  table.Request(WholeRequestOf("another server's"));
  EXPECT_THAT(table.TakeWholes(), IsEmpty());
}

TEST_F(SceneChangesTest, AreUndoneWithoutAskingForMemory) {
  Ask("a", "bur");
  Cut(800);
  table_.Request(WholeRequestOf("block"));
  const std::uint64_t before = AllocationsOfThisThread();
  Send("a", 1e-3);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate::test
