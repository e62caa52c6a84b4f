#include "devices/device_factory.h"

#include <limits>
#include <random>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "devices/arm_parts.h"
#include "tests/devices/limiter_support.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

PoseScript Still() {
  const Pose at{Vec3(0.0, 0.0, 0.1), Quat::Identity()};
  return PoseScript({{0.0, at, "hold"}, {1.0, at, "hold"}});
}

DeviceOptions Of(const std::string& name) {
  DeviceOptions options;
  options.name = name;
  options.script = Still();
  return options;
}

std::string MessageOf(const DeviceOptions& options) {
  return test::ComplaintOf([&] { MakeDevice(options); });
}

TEST(DeviceFactory, MakesWhatItNames) {
  EXPECT_EQ(
      DeviceNames(),
      "forcedimension, haply, mouse, openhaptics, ./DRIVER.so, scripted, simulated, spacemouse");
  for (const char* name : {"simulated", "scripted"}) {
    const auto device = MakeDevice(Of(name));
    EXPECT_NE(device->info().model.find(name), std::string::npos);
    EXPECT_NEAR(device->Read().X_WH.p.z(), 0.1, 1e-9);
    EXPECT_STREQ(device->activity(), "hold");
  }
}

TEST(DeviceFactory, HelpsWithALineForEachDeviceAndItsModels) {
  for (const char* text : {"  mouse ", "  scripted ", "  simulated ", "  spacemouse ",
                           "--model premium-3.0, premium-1.5, touch"}) {
    EXPECT_NE(DeviceHelp().find(text), std::string::npos) << text;
  }
}

TEST(DeviceFactory, NamesWhatThereIsWhereItIsAskedForWhatThereIsNot) {
  EXPECT_EQ(
      MessageOf(Of("omega")),
      "--device omega: is not a device; give one of forcedimension, haply, mouse, openhaptics, "
      "./DRIVER.so, scripted, simulated, spacemouse");
  DeviceOptions options = Of("simulated");
  options.model = "omni";
  EXPECT_EQ(MessageOf(options),
            "--model omni: is not a model of --device simulated; give one of premium-3.0, "
            "premium-1.5, touch");
  options = Of("scripted");
  options.model = "touch";
  EXPECT_EQ(MessageOf(options), "--model touch: --device scripted has no models; leave it out");
  options = Of("scripted");
  options.rate_Hz = 2000.0;
  EXPECT_EQ(MessageOf(options), "--rate 2000: --device scripted runs at 1000 Hz");
  options = Of("simulated");
  options.rate_Hz = 8000.0;
  EXPECT_EQ(MessageOf(options), "--rate 8000: --device simulated runs at 1000 to 4000 Hz");
}

TEST(DeviceFactory, MakesTheModelAtTheRateThatItIsAskedFor) {
  EXPECT_EQ(MakeDevice(Of("simulated"))->info().max_force_N, 22.0);
  DeviceOptions options = Of("simulated");
  options.model = "touch";
  options.rate_Hz = 4000.0;
  const auto device = MakeDevice(options);
  EXPECT_EQ(device->info().max_force_N, 3.3);
  EXPECT_EQ(device->info().rate_Hz, 4000.0);
}

TEST(DeviceFactory, PlaysAScriptOfTheSceneInWhateverWorkspace) {
  DeviceOptions options = Of("scripted");
  const Pose a{Vec3(0.1, 0.2, 0.3), RotationExp(Vec3(0.3, -0.2, 0.1))};
  const Pose b{Vec3(0.15, 0.1, 0.3), Quat::Identity()};
  options.script = PoseScript({{0.0, a, ""}, {0.1, b, ""}});
  options.workspace.emplace();
  options.workspace->scale = 3.0;
  options.workspace->centre_m = Vec3(0.01, 0.02, 0.03);
  options.workspace->X_WD = {Vec3(0.2, 0, 0), RotationExp(Vec3(0, 1, 0.5))};
  options.workspace->q_HT = RotationExp(Vec3(1, 0, 0));
  const auto device = MakeDevice(options);
  for (int i = 0; i < 100; ++i) {
    const Pose wanted = options.script->At(1e-3 * i);
    const Pose seen = device->Read().X_WH;
    ASSERT_LT((seen.p - wanted.p).norm(), 1e-12);
    ASSERT_LT(RotationLog(seen.q * wanted.q.conjugate()).norm(), 1e-12);
    device->Apply(PassThrough({}));
  }
}

TEST(DeviceFactory, AsksForAScriptWhereItNeedsOne) {
  EXPECT_TRUE(DeviceNeedsScript("simulated"));
  DeviceOptions options = Of("simulated");
  options.script.reset();
  EXPECT_THROW(MakeDevice(options), Error);
}

TEST(NearestRotation, IsThePolarFactorThatTheSingularValueDecompositionGives) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 phi = 3.0 * Vec3(uniform(random), uniform(random), uniform(random));
    Mat3 matrix = RotationExp(phi).toRotationMatrix();
    for (double& element : matrix.reshaped()) element += 0.01 * uniform(random);
    const Eigen::JacobiSVD<Mat3> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 truth = svd.matrixU() * svd.matrixV().transpose();
    const std::optional<Mat3> R = NearestRotation(matrix);
    ASSERT_TRUE(R);
    EXPECT_LT((*R - truth).norm(), 1e-14);
    EXPECT_LT((*R * R->transpose() - Mat3::Identity()).norm(), 1e-15 * 8);
  }
}

TEST(NearestRotation, RefusesWhatIsNoRotation) {
  Mat3 matrix = Mat3::Identity();
  matrix(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(NearestRotation(matrix));
  EXPECT_FALSE(NearestRotation(Mat3::Zero()));
  EXPECT_FALSE(NearestRotation(-Mat3::Identity()));
  EXPECT_FALSE(NearestRotation(Vec3(1, 1, -1).asDiagonal()));
  EXPECT_FALSE(NearestRotation(1.2 * Mat3::Identity()));
  EXPECT_FALSE(NearestRotation(1e200 * Mat3::Identity()));
}

const Wrench kSome{Vec3(0.0, 1e-9, 0.0), Vec3::Zero()};

bool PassesAfter(ReturnGate& gate, int ticks, const Wrench& wrench) {
  for (int i = 1; i < ticks; ++i) gate.Passes(wrench);
  return gate.Passes(wrench);
}

TEST(ReturnGate, OpensOnlyAfterQuietAndOnceNothingIsAskedFor) {
  ReturnGate gate(1000.0);
  EXPECT_FALSE(PassesAfter(gate, 5000, kSome)) << "a step would come of it";
  EXPECT_TRUE(gate.Passes(Wrench{}));
  EXPECT_TRUE(gate.Passes(kSome));
}

TEST(ReturnGate, ShutsWithAFaultAndCountsItsQuietAnew) {
  ReturnGate gate(1000.0);
  ASSERT_TRUE(PassesAfter(gate, 101, Wrench{}));
  gate.Fault();
  EXPECT_FALSE(gate.Passes(kSome));
  EXPECT_FALSE(PassesAfter(gate, 98, Wrench{}));
  gate.Fault();
  EXPECT_FALSE(PassesAfter(gate, 100, Wrench{}));
  EXPECT_TRUE(gate.Passes(Wrench{}));
}

}  // namespace
}  // namespace palpate
