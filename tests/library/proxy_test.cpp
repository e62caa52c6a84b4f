#include "server/library/proxy.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/library/body_builder.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

HapticModel BoxInBox(ContactModel contact) {
  Scene scene;
  scene.features.contact = contact;
  scene.objects.push_back(
      MakeBody("block", MakeBox({0.04, 0.04, 0.04}), {.leaves = 512, .contact = contact}));
  scene.tools.push_back(
      MakeBody("probe", MakeBox({0.01, 0.01, 0.01}), {.leaves = 128, .contact = contact}));
  return MakeModel(scene, scene.tools[0], MakeObjects(scene));
}

/// A hand that comes down on the block, turns, and slides about in it.
std::vector<Pose> HandPath(int steps, std::uint64_t seed) {
  Random random(seed);
  Pose X;
  X.p = {0.0, 0.03, 0.0};
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();
  std::vector<Pose> path;
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < 3; ++k) {
      v[k] = 0.98 * v[k] + random.Uniform(-1e-5, 1e-5);
      w[k] = 0.98 * w[k] + random.Uniform(-1e-3, 1e-3);
    }
    X.p += v + 1e-3 * (Vec3(0.0, 0.023, 0.0) - X.p);
    X.q = (RotationExp(w) * X.q).normalized();
    path.push_back(X);
  }
  return path;
}

bool SameBits(const StepReport& a, const StepReport& b) {
  const auto same = [](const auto& u, const auto& v) {
    return std::memcmp(u.data(), v.data(), sizeof(double) * u.size()) == 0;
  };
  return same(a.wrench.force, b.wrench.force) && same(a.wrench.torque, b.wrench.torque) &&
         same(a.X_WG.p, b.X_WG.p) && same(a.X_WG.q.coeffs(), b.X_WG.q.coeffs()) &&
         a.contacts == b.contacts && a.faults == b.faults;
}

class ProxyOf : public ::testing::TestWithParam<ContactModel> {};
INSTANTIATE_TEST_SUITE_P(Contact, ProxyOf,
                         ::testing::Values(ContactModel::kSurface, ContactModel::kSpheres),
                         [](const auto& info) {
                           return info.param == ContactModel::kSurface ? "surface" : "spheres";
                         });

TEST_P(ProxyOf, GivesTheBitsOfTheStep) {
  const HapticModel model = BoxInBox(GetParam());
  const std::vector<Pose> path = HandPath(2000, 3);
  Proxy proxy(model, path[0]);
  StepWorkspace workspace(model);
  StepState state(model);
  state.X_WG = ResolveStart(model, path[0], workspace).X_WG;
  int touched = 0;
  for (Pose X_WH : path) {
    const StepReport report = proxy.Step(X_WH);
    X_WH.q.coeffs() /= std::sqrt(X_WH.q.squaredNorm());  // as the server does
    ASSERT_TRUE(SameBits(report, HapticStep(model, X_WH, state, workspace)));
    touched += report.contacts > 0;
  }
  EXPECT_GT(touched, 500);
}

TEST_P(ProxyOf, GoesOnAlikeFromAStateThatWasPutBack) {
  const HapticModel model = BoxInBox(GetParam());
  const std::vector<Pose> path = HandPath(1500, 5);
  Proxy proxy(model, path[0]);
  for (int i = 0; i < 1000; ++i) proxy.Step(path[i]);
  const StepState state = proxy.state();
  std::vector<StepReport> first;
  for (int i = 1000; i < 1500; ++i) first.push_back(proxy.Step(path[i]));
  proxy.set_state(state);
  for (int i = 1000; i < 1500; ++i) ASSERT_TRUE(SameBits(first[i - 1000], proxy.Step(path[i])));
}

TEST_P(ProxyOf, BeginsFreeWhereTheHandIsInside) {
  const HapticModel model = BoxInBox(GetParam());
  Pose X_WH;
  X_WH.p = {0.0, 0.022, 0.0};  // 3 mm in
  Proxy proxy(model, X_WH);
  EXPECT_NEAR(proxy.start_depth(), 3e-3, 3e-4);
  const StepReport report = proxy.Step(X_WH);
  EXPECT_NEAR(report.wrench.force.y(), 3.0, 0.3);
  X_WH.p.y() = 0.05;
  proxy.Restart(X_WH);
  EXPECT_EQ(proxy.start_depth(), 0.0);
  EXPECT_EQ(proxy.Step(X_WH).wrench.force, Vec3::Zero());
}

TEST_P(ProxyOf, ReportsWhatItsStepsAreMadeWithAndTheirTimes) {
  const HapticModel model = BoxInBox(GetParam());
  Pose X_WH;
  X_WH.p = {0.0, 0.022, 0.0};
  Proxy proxy(model, X_WH), timed(model, X_WH);
  StageTimes times;
  const StepReport report = proxy.Step(X_WH);
  EXPECT_EQ(report.parameters, &model.parameters());
  EXPECT_TRUE(SameBits(report, timed.Step(X_WH, &times)));
  EXPECT_GT(times.solve, 0);
}

TEST(Proxy, RefusesPosesThatAreNone) {
  Scene scene;
  scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04}), {.leaves = 64}));
  scene.tools.push_back(MakeBall("ball", 0.005));
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  Pose turned;
  turned.q.coeffs() *= 2.0;
  EXPECT_THROW(Proxy(model, turned), Error);
  scene.objects[0].X_WB = turned;
  EXPECT_THROW(MakeObjects(scene), Error);
}

}  // namespace
}  // namespace palpate::test
