#include "server/library/scenes.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/dds/wire.h"
#include "scenes/files/scene_bundle.h"
#include "server/library/palpate.h"
#include "server/session/session.h"
#include "tests/support/effects_scene.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using ::testing::HasSubstr;

/// A session of the scene's first tool, as the server runs it.
class Served {
 public:
  explicit Served(const Scene& scene)
      : session_("left", 7,
                 std::make_shared<const ServedTool>(
                     ServedTool{scene.name, scene.tools[0].name,
                                MakeModel(scene, scene.tools[0], MakeObjects(scene))}),
                 0) {}
  wire::Wrench Step(const Pose& X_WH) {
    wire::HapticPose pose{};
    pose.pose_sequence = ++sequence_;
    pose.sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sequence_);
    wire::FromPose(X_WH, pose.position_m, pose.orientation_wxyz);
    wire::Wrench answer{};
    session_.loop().OnPose(pose, answer);
    // Two polls: one tells the start, and the next gives it to the loop.
    for (int i = 0; i < 2; ++i) session_.Update(pose.sample_time_ns);
    return answer;
  }

 private:
  std::uint64_t sequence_ = 0;
  Session session_;
};

/// @field from, steps  part of its hand's script [ms] in which it touches.
struct Walk {
  std::string scene;
  int from, steps;
};

class LoadedScene : public ::testing::TestWithParam<Walk> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, LoadedScene,
                         ::testing::Values(Walk{"bunny-bunny", 4000, 3000},
                                           Walk{"periodontal", 2000, 5000},
                                           Walk{"oral-cavity", 10'000, 4000},
                                           Walk{"friction", 2000, 5000},
                                           Walk{"caries", 3000, 1000}),
                         [](const auto& walk) {
                           std::string name = walk.param.scene;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(LoadedScene, GivesTheBitsOfTheServer) {
  const auto& [name, from, steps] = GetParam();
  const Scene scene = LoadScene(name);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  const PoseScript hand = PoseScript::Load(ScriptFileBeside(name));
  Served served(scene);
  served.Step(hand.At(1e-3 * from));
  Proxy proxy(model, hand.At(1e-3 * from));
  int touched = 0;
  for (int ms = 1; ms < steps; ++ms) {
    const Pose X_WH = hand.At(1e-3 * (from + ms));
    const wire::Wrench answer = served.Step(X_WH);
    const StepReport report = proxy.Step(X_WH);
    wire::Wrench own = answer;
    wire::FromPose(report.X_WG, own.graphic_position_m, own.graphic_orientation_wxyz);
    own.faults = report.faults;
    if (ms > 210) {  // until then the server lets the force in
      wire::FromVec3(report.wrench.force, own.force_N);
      wire::FromVec3(report.wrench.torque, own.torque_Nm);
    }
    ASSERT_EQ(std::memcmp(&own, &answer, sizeof own), 0) << ms << " ms";
    touched += answer.contacts > 0;
  }
  EXPECT_GT(touched, 300);
}

TEST(LoadedWithEffects, GivesTheBitsOfTheServerInCxxAndInC) {
  const Folder folder;
  const std::string name = folder / "six.json";
  std::ofstream(name) << CubeWithEffects(R"(
      {"name": "viscous"}, {"name": "stick"}, {"name": "vibration"},
      {"name": "forbidden", "centre_mm": [0, 20, 0], "radius_mm": 8},
      {"name": "magnet", "curve_mm": [[-20, 30, 0], [20, 30, 0]]},
      {"name": "moving_spring", "from_mm": [0, 40, 0], "to_mm": [9, 40, 0]})");
  std::filesystem::copy(ScriptFileBeside("cube"), folder / "six.path.json");
  const Scene scene = LoadScene(name);
  ASSERT_EQ(scene.effects.size(), 6u);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  const PoseScript hand = PoseScript::Load(ScriptFileBeside(name));
  Served served(scene);
  served.Step(hand.At(0.0));
  Proxy proxy(model, hand.At(0.0));
  palpate_scene* loaded = palpate_scene_load(name.c_str());
  ASSERT_NE(loaded, nullptr) << palpate_last_error();
  palpate_model* c_model = palpate_model_new(loaded, 0);
  palpate_pose pose;
  palpate_scene_hand(loaded, 0.0, &pose);
  palpate_proxy* c_proxy = palpate_proxy_new(c_model, &pose);
  for (int ms = 1; ms < 5000; ++ms) {
    const wire::Wrench answer = served.Step(hand.At(1e-3 * ms));
    const StepReport report = proxy.Step(hand.At(1e-3 * ms));
    palpate_scene_hand(loaded, 1e-3 * ms, &pose);
    palpate_report in_c;
    palpate_proxy_step(c_proxy, &pose, &in_c);
    if (ms <= 210) continue;  // until then the server lets the force in
    ASSERT_EQ(Vec3(answer.force_N), report.wrench.force) << ms;
    ASSERT_EQ(Vec3(answer.torque_Nm), report.wrench.torque) << ms;
    ASSERT_EQ(Vec3(in_c.force_N), report.wrench.force) << ms;
    ASSERT_FALSE(report.effects.passive.force.isZero(0.0));
    ASSERT_FALSE(report.effects.active.force.isZero(0.0));
  }
  palpate_proxy_free(c_proxy);
  palpate_model_free(c_model);
  palpate_scene_free(loaded);
}

TEST(LoadedInC, HasAsManyLeavesAsAToleranceNeeds) {
  const Scene scene = LoadScene("cube", {.leaves = HeightTolerance(500.0)});
  palpate_scene* loaded = palpate_scene_load_to("cube", 500.0);
  ASSERT_NE(loaded, nullptr) << palpate_last_error();
  const Folder folder;
  const std::string file = folder / "cube.palpate";
  ASSERT_EQ(palpate_scene_save(loaded, file.c_str()), 0) << palpate_last_error();
  palpate_scene_free(loaded);
  EXPECT_EQ(LoadScene(file).objects[0].tree.leaves(), scene.objects[0].tree.leaves());
  EXPECT_NE(scene.objects[0].tree.leaves(), LoadScene("cube").objects[0].tree.leaves());
  EXPECT_EQ(palpate_scene_load_to("cube", 0.0), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("tolerance_um: must be from 0.1"));
}

TEST(LoadedInC, GivesTheBitsOfCxxWithTheParametersThatAreSet) {
  palpate_scene* loaded = palpate_scene_load("cube");
  ASSERT_NE(loaded, nullptr) << palpate_last_error();
  Scene scene = LoadScene("cube");
  EXPECT_EQ(palpate_scene_tool(loaded, 0, nullptr), scene.tools[0].name);
  EXPECT_EQ(palpate_scene_tool(loaded, scene.tools.size(), nullptr), nullptr);
  ASSERT_EQ(palpate_scene_set_parameter(loaded, "friction", 0.4), 0) << palpate_last_error();
  SetParameter(scene, "friction", 0.4);
  palpate_parameter last{}, parameter{};
  std::size_t count = 0;
  while (palpate_scene_parameter(loaded, count, &parameter) == 0) last = parameter, ++count;
  EXPECT_EQ(count, ParametersOf(scene).size());
  EXPECT_STREQ(last.name, "friction");
  EXPECT_EQ(last.value, 0.4);

  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  const PoseScript hand = PoseScript::Load(ScriptFileBeside("cube"));
  EXPECT_EQ(palpate_scene_hand(loaded, 0.0, nullptr), hand.duration());
  palpate_model* c_model = palpate_model_new(loaded, 0);
  palpate_pose pose;
  palpate_scene_hand(loaded, 0.0, &pose);
  palpate_proxy* c_proxy = palpate_proxy_new(c_model, &pose);
  Proxy proxy(model, hand.At(0.0));
  int touched = 0;
  for (double t = 0.0; t < hand.duration(); t += 0.001) {
    palpate_scene_hand(loaded, t, &pose);
    palpate_report report;
    palpate_proxy_step(c_proxy, &pose, &report);
    const StepReport own = proxy.Step(hand.At(t));
    ASSERT_EQ(std::memcmp(report.force_N, own.wrench.force.data(), sizeof report.force_N), 0) << t;
    touched += report.contacts > 0;
  }
  EXPECT_GT(touched, 300);
  palpate_report report;
  palpate_proxy_step(c_proxy, &pose, &report);
  ASSERT_EQ(report.parameters, count);
  EXPECT_STREQ(report.parameter[count - 1].name, "friction");
  EXPECT_EQ(report.parameter[count - 1].value, 0.4);

  const std::string file = testing::TempDir() + "saved_in_c.palpate";
  ASSERT_EQ(palpate_scene_save(loaded, file.c_str()), 0) << palpate_last_error();
  EXPECT_EQ(PackScene(LoadScene(file)), PackScene(scene));
  EXPECT_NE(palpate_scene_save(loaded, "saved_in_c.json"), 0);
  EXPECT_STREQ(palpate_last_error(), "saved_in_c.json: give a name that ends in .palpate");
  std::filesystem::remove(file);
  palpate_proxy_free(c_proxy);
  palpate_model_free(c_model);
  palpate_scene_free(loaded);
}

}  // namespace
}  // namespace palpate::test
