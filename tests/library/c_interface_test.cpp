#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "common/revision.h"
#include "scenes/shapes/shapes.h"
#include "server/library/body_builder.h"
#include "server/library/palpate.h"
#include "server/library/proxy.h"
#include "server/physics/scene_model.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

using ::testing::HasSubstr;

struct Free {
  void operator()(palpate_scene* scene) const { palpate_scene_free(scene); }
  void operator()(palpate_model* model) const { palpate_model_free(model); }
  void operator()(palpate_proxy* proxy) const { palpate_proxy_free(proxy); }
};
using ScenePtr = std::unique_ptr<palpate_scene, Free>;
using ModelPtr = std::unique_ptr<palpate_model, Free>;
using ProxyPtr = std::unique_ptr<palpate_proxy, Free>;

constexpr double kBlock_m[3] = {0.04, 0.04, 0.04};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

palpate_pose At(double y) {
  return {{0.0, y, 0.0}, {1.0, 0.0, 0.0, 0.0}};
}

ScenePtr BallOnBlock(palpate_contact contact, const palpate_body* block = nullptr) {
  ScenePtr scene(palpate_scene_new(contact));
  EXPECT_EQ(palpate_scene_add_box(scene.get(), PALPATE_OBJECT, "block", kBlock_m, block), 0)
      << palpate_last_error();
  EXPECT_EQ(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", 0.005, nullptr), 0)
      << palpate_last_error();
  return scene;
}

TEST(CInterface, TellsWhichBuildItIs) {
  EXPECT_STREQ(palpate_version(), PALPATE_VERSION);
  EXPECT_STREQ(palpate_physics_revision(), kPhysicsRevision);
}

TEST(CInterface, GivesTheBitsOfTheCxxOne) {
  const TriangleMesh egg = MakeEllipsoid({0.03, 0.02, 0.01}, 320);
  ScenePtr scene(palpate_scene_new(PALPATE_SURFACE));
  palpate_body body = palpate_body_defaults();
  body.leaves = 256;
  std::vector<double> vertices;
  for (const Vec3& v : egg.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
  ASSERT_EQ(palpate_scene_add_mesh(scene.get(), PALPATE_OBJECT, "egg", vertices.data(),
                                   egg.vertices.size(), egg.triangles[0].data(),
                                   egg.triangles.size(), &body),
            0)
      << palpate_last_error();
  ASSERT_EQ(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", 0.004, nullptr), 0);
  ModelPtr model(palpate_model_new(scene.get(), 0));
  ASSERT_TRUE(model) << palpate_last_error();
  scene.reset();
  palpate_pose hand = At(0.03);
  ProxyPtr proxy(palpate_proxy_new(model.get(), &hand));
  ASSERT_TRUE(proxy) << palpate_last_error();
  model.reset();  // the proxy keeps the model alive

  Scene same;
  same.objects.push_back(MakeBody("egg", egg, {.leaves = 256}));
  same.tools.push_back(MakeBall("ball", 0.004));
  const HapticModel same_model = MakeModel(same, same.tools[0], MakeObjects(same));
  Pose X_WH;
  X_WH.p = {0.0, 0.03, 0.0};
  Proxy same_proxy(same_model, X_WH);
  int touched = 0;
  for (int i = 0; i < 2000; ++i) {
    hand.position_m[0] = X_WH.p.x() = 0.01 * std::sin(0.004 * i);
    hand.position_m[1] = X_WH.p.y() = 0.022 - 0.004 * std::sin(0.01 * i);
    palpate_report report;
    palpate_proxy_step(proxy.get(), &hand, &report);
    const StepReport expected = same_proxy.Step(X_WH);
    ASSERT_EQ(std::memcmp(report.force_N, expected.wrench.force.data(), sizeof report.force_N), 0);
    ASSERT_EQ(
        std::memcmp(report.tool.position_m, expected.X_WG.p.data(), sizeof report.tool.position_m),
        0);
    ASSERT_EQ(report.points, expected.contacts);
    touched += report.contacts > 0;
  }
  EXPECT_GT(touched, 500);
}

TEST(CInterface, FeelsMaterials) {
  palpate_body hard = palpate_body_defaults(), soft = hard;
  hard.leaves = soft.leaves = 1000;
  soft.stiffness_N_m = 300.0;
  for (const palpate_body* block : {&hard, &soft}) {
    const ScenePtr scene = BallOnBlock(PALPATE_SPHERES, block);
    const ModelPtr model(palpate_model_new(scene.get(), 0));
    ASSERT_TRUE(model) << palpate_last_error();
    palpate_pose hand = At(0.03);
    const ProxyPtr proxy(palpate_proxy_new(model.get(), &hand));
    palpate_report report{};
    for (int i = 0; i < 1000; ++i) {
      hand.position_m[1] -= 7e-6;  // to 2 mm below the first touch
      palpate_proxy_step(proxy.get(), &hand, &report);
    }
    EXPECT_GT(report.contacts, 0);
    if (block == &soft) {
      EXPECT_LT(report.force_N[1], 1.5);
    } else {
      EXPECT_NEAR(report.force_N[1], 2.0, 0.2);
    }
    // The listed forces add up to the wrench, as far as they are listed.
    if (report.contacts == report.points) {
      double sum = 0.0;
      for (int i = 0; i < report.points; ++i) sum += report.point[i].force_N[1];
      EXPECT_NEAR(sum, report.force_N[1], 1e-6);
    }
  }
}

TEST(CInterface, SaysWhatIsWrongAndGoesOn) {
  EXPECT_EQ(palpate_scene_new(static_cast<palpate_contact>(7)), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("contact"));
  EXPECT_NE(palpate_scene_add_ball(nullptr, PALPATE_TOOL, "ball", 0.01, nullptr), 0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("scene: is NULL"));

  ScenePtr scene(palpate_scene_new(PALPATE_SURFACE));
  EXPECT_EQ(palpate_model_new(scene.get(), 0), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("no tool 0"));
  EXPECT_NE(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", -1.0, nullptr), 0);
  EXPECT_NE(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, nullptr, 1.0, nullptr), 0);
  EXPECT_NE(palpate_scene_add_ball(scene.get(), static_cast<palpate_role>(9), "b", 1.0, nullptr),
            0);
  EXPECT_NE(palpate_scene_add_box(scene.get(), PALPATE_TOOL, "box", nullptr, nullptr), 0);
  const double vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::uint32_t bad[3] = {0, 1, 77};
  EXPECT_NE(palpate_scene_add_mesh(scene.get(), PALPATE_TOOL, "m", vertices, 3, bad, 1, nullptr),
            0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("m: triangle 0 names vertex 77 of 3"));
  EXPECT_NE(palpate_scene_add_mesh(scene.get(), PALPATE_TOOL, "m", vertices, 0, bad, 0, nullptr),
            0);
  palpate_body body{};  // not from palpate_body_defaults()
  EXPECT_NE(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", 0.01, &body), 0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("palpate_body_defaults()"));
  body = palpate_body_defaults();
  body.pose.orientation_wxyz[0] = kNan;
  EXPECT_NE(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", 0.01, &body), 0);
  EXPECT_NE(palpate_scene_set_parameter(scene.get(), "stiffness_N_per_m", -1.0), 0);
  EXPECT_NE(palpate_scene_set_parameter(scene.get(), "separation_um", kNan), 0);
  EXPECT_EQ(palpate_scene_load("bunny-buny"), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("bunny-bunny"));
  EXPECT_EQ(palpate_scene_load(nullptr), nullptr);
  EXPECT_EQ(palpate_scene_tool(scene.get(), 9, nullptr), nullptr);
  EXPECT_EQ(palpate_scene_hand(scene.get(), 0.0, nullptr), 0.0);

  // A scene with a tool and nothing to feel.
  EXPECT_EQ(palpate_scene_add_ball(scene.get(), PALPATE_TOOL, "ball", 0.01, nullptr), 0);
  EXPECT_EQ(palpate_model_new(scene.get(), 0), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("no object"));
  EXPECT_EQ(palpate_proxy_new(nullptr, nullptr), nullptr);
  palpate_scene_free(nullptr);
  palpate_model_free(nullptr);
  palpate_proxy_free(nullptr);
}

TEST(CInterface, KeepsEachThreadsErrorApart) {
  EXPECT_EQ(palpate_scene_new(static_cast<palpate_contact>(7)), nullptr);
  std::string elsewhere;
  std::thread([&] { elsewhere = palpate_last_error(); }).join();
  EXPECT_EQ(elsewhere, "nothing has gone wrong");
  EXPECT_THAT(palpate_last_error(), HasSubstr("contact"));
}

TEST(CInterface, GivesNoForceForAPoseThatIsNone) {
  const ScenePtr scene = BallOnBlock(PALPATE_SURFACE);
  const ModelPtr model(palpate_model_new(scene.get(), 0));
  palpate_pose hand = At(0.023);
  const ProxyPtr proxy(palpate_proxy_new(model.get(), &hand));
  palpate_report report;
  EXPECT_EQ(palpate_proxy_step(proxy.get(), &hand, &report), 0u);
  EXPECT_GT(report.force_N[1], 1.0);
  for (double* number : {&hand.position_m[2], &hand.orientation_wxyz[3]}) {
    for (const double value : {kNan, std::numeric_limits<double>::infinity(), -1e308}) {
      hand = At(0.023);
      *number = value;
      EXPECT_NE(palpate_proxy_step(proxy.get(), &hand, &report), 0u) << value;
      for (const double force : report.force_N) EXPECT_TRUE(std::isfinite(force));
      for (const double position : report.tool.position_m) EXPECT_TRUE(std::isfinite(position));
    }
  }
  hand = At(0.023);
  hand.orientation_wxyz[0] = 2.0;
  EXPECT_NE(palpate_proxy_step(proxy.get(), &hand, &report), 0u);
  EXPECT_EQ(report.force_N[1], 0.0);
  EXPECT_EQ(palpate_proxy_new(model.get(), &hand), nullptr);
  EXPECT_THAT(palpate_last_error(), HasSubstr("no unit quaternion"));
  hand = At(0.023);
  EXPECT_NE(palpate_proxy_step(nullptr, &hand, &report), 0u);
  EXPECT_EQ(report.force_N[1], 0.0);
  EXPECT_NE(palpate_proxy_step(proxy.get(), nullptr, &report), 0u);
  EXPECT_NE(palpate_proxy_step(proxy.get(), &hand, nullptr), 0u);
  char words[8];
  const std::size_t all = palpate_fault_words(1u, words, sizeof words);
  EXPECT_GT(all, std::strlen(words));
}

TEST(CInterface, AsksForNoMemoryInAStep) {
  const ScenePtr scene = BallOnBlock(PALPATE_SURFACE);
  const ModelPtr model(palpate_model_new(scene.get(), 0));
  palpate_pose hand = At(0.026);
  const ProxyPtr proxy(palpate_proxy_new(model.get(), &hand));
  palpate_report report;
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 1000; ++i) {
    hand.position_m[1] -= 3e-6;
    palpate_proxy_step(proxy.get(), &hand, &report);
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(report.force_N[1], 1.0);
}

TEST(CInterface, RefusesNamesAndMaterialsThatSceneFilesRefuse) {
  const ScenePtr scene = BallOnBlock(PALPATE_SURFACE);
  const double size[3] = {0.01, 0.01, 0.01};
  const auto add = [&](const char* name, const palpate_body* body) {
    return palpate_scene_add_box(scene.get(), PALPATE_OBJECT, name, size, body);
  };
  EXPECT_EQ(add("one", nullptr), 0);
  EXPECT_NE(add("one", nullptr), 0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("one"));
  EXPECT_NE(add("", nullptr), 0);
  palpate_body rough = palpate_body_defaults();
  rough.static_friction = 11.0;
  EXPECT_NE(add("rough", &rough), 0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("11"));
}

TEST(CInterface, SavesAProxyThatAnotherContinues) {
  const ScenePtr scene = BallOnBlock(PALPATE_SURFACE);
  const ModelPtr model(palpate_model_new(scene.get(), 0));
  palpate_pose hand = At(0.026);
  const ProxyPtr proxy(palpate_proxy_new(model.get(), &hand));
  palpate_report report, other;
  for (int i = 0; i < 500; ++i) {
    hand.position_m[1] -= 6e-6;
    palpate_proxy_step(proxy.get(), &hand, &report);
  }
  const std::size_t size = palpate_proxy_save(proxy.get(), nullptr, 0);
  ASSERT_GT(size, 0u);
  std::vector<unsigned char> bytes(size, 0xee);
  EXPECT_EQ(palpate_proxy_save(proxy.get(), bytes.data(), size - 1), size);
  EXPECT_EQ(bytes, std::vector<unsigned char>(size, 0xee));  // not written in part
  EXPECT_EQ(palpate_proxy_save(proxy.get(), bytes.data(), size), size);
  const palpate_pose air = At(0.04);
  const ProxyPtr there(palpate_proxy_new(model.get(), &air));
  bytes[size / 2] ^= 4;
  EXPECT_NE(palpate_proxy_restore(there.get(), bytes.data(), size), 0);
  EXPECT_THAT(palpate_last_error(), HasSubstr("damaged"));
  bytes[size / 2] ^= 4;
  EXPECT_NE(palpate_proxy_restore(there.get(), bytes.data(), size - 1), 0);
  EXPECT_NE(palpate_proxy_restore(there.get(), nullptr, 0), 0);
  EXPECT_NE(palpate_proxy_restore(nullptr, bytes.data(), size), 0);
  ASSERT_EQ(palpate_proxy_restore(there.get(), bytes.data(), size), 0) << palpate_last_error();
  for (int i = 0; i < 50; ++i) {
    hand.position_m[0] += 1e-6;
    palpate_proxy_step(proxy.get(), &hand, &report);
    palpate_proxy_step(there.get(), &hand, &other);
    EXPECT_EQ(std::memcmp(report.force_N, other.force_N, sizeof report.force_N), 0);
    EXPECT_EQ(std::memcmp(&report.tool, &other.tool, sizeof report.tool), 0);
  }
  EXPECT_GT(report.force_N[1], 1.0);
}

}  // namespace
}  // namespace palpate::test
