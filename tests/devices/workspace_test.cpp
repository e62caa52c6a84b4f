#include "devices/workspace.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "devices/simulated/simulated_phantom.h"
#include "tests/devices/limiter/limiter_figures.h"
#include "tests/devices/limiter_support.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/optimised.h"
#include "tests/support/random.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::kTick;
using testing::HasSubstr;

double Angle(const Quat& a, const Quat& b) {
  return RotationLog(a * b.conjugate()).norm();
}

Workspace Any(test::Random& random) {
  Workspace workspace;
  workspace.centre_m = random.InCube(0.1);
  workspace.X_WD = {random.InCube(0.5), random.Rotation()};
  workspace.q_HT = random.Rotation();
  workspace.scale =
      std::exp(random.Uniform(std::log(Workspace::kLeastScale), std::log(Workspace::kMostScale)));
  return workspace;
}

double Power(const Wrench& wrench, const Twist& V) {
  return wrench.force.dot(V.v) + wrench.torque.dot(V.w);
}

/// A device held where the test says, which keeps what it was told.
class HeldDevice final : public Device {
 public:
  explicit HeldDevice(const DeviceInfo& info) : info_(info) {}
  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override { return sample; }
  void Apply(const LimitedWrench& limited) noexcept override { applied = limited.wrench(); }
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override {
    graphic = X_WG;
    reference = p_HT;
  }
  const char* activity() const noexcept override { return "held"; }

  DeviceSample sample;
  Wrench applied;
  Pose graphic;
  Vec3 reference;

 private:
  DeviceInfo info_;
};

/// A WorkspaceDevice and the device inside it.
struct Pair {
  explicit Pair(const Workspace& workspace, const DeviceInfo& info = PhantomPremium30().info) {
    auto inside = std::make_unique<HeldDevice>(info);
    held = inside.get();
    device = std::make_unique<WorkspaceDevice>(std::move(inside), workspace);
  }
  HeldDevice* held;
  std::unique_ptr<WorkspaceDevice> device;
};

TEST(Workspace, LeavesEverythingAsItIsWhereNothingIsSaid) {
  test::Random random(1);
  const Workspace nothing;
  const Pose X{random.InCube(1.0), random.Rotation()};
  EXPECT_EQ(nothing.ToScene(X).p, X.p);
  EXPECT_LT(Angle(nothing.ToScene(X).q, X.q), 1e-15);
}

TEST(Workspace, ComesBackToTheSamePose) {
  test::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Workspace workspace = Any(random);
    const Pose X{random.InCube(0.5), random.Rotation()};
    const Pose back = workspace.ToDevice(workspace.ToScene(X));
    ASSERT_LT((back.p - X.p).norm(), 1e-12);
    ASSERT_LT(Angle(back.q, X.q), 1e-14);
    const Wrench wrench{random.InCube(5.0), random.InCube(0.5)};
    const Wrench wrench_back = workspace.ToDevice(workspace.ToScene(wrench));
    ASSERT_LT((wrench_back.force - wrench.force).norm(), 1e-13);
    ASSERT_LT((wrench_back.torque - wrench.torque).norm(), 1e-13);
  }
}

TEST(Workspace, GivesTheVelocityOfThePoseThatItGives) {
  test::Random random(3);
  const double h = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const Workspace workspace = Any(random);
    const Pose X{random.InCube(0.2), random.Rotation()};
    const Twist V{random.InCube(0.5), random.InCube(3.0)};
    const Pose later{X.p + h * V.v, RotationExp(h * V.w) * X.q};
    const Twist seen = workspace.ToScene(V);
    const Pose a = workspace.ToScene(X), b = workspace.ToScene(later);
    ASSERT_LT(((b.p - a.p) / h - seen.v).norm(), 1e-6 * (1.0 + seen.v.norm()));
    ASSERT_LT((RotationLog(b.q * a.q.conjugate()) / h - seen.w).norm(), 1e-6);
  }
}

TEST(Workspace, KeepsPowerAtScaleOneAndDividesItByTheScaleOtherwise) {
  test::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    Workspace workspace = Any(random);
    if (i % 2 == 0) workspace.scale = 1.0;
    const Twist V_D{random.InCube(0.5), random.InCube(3.0)};
    const Wrench F_W{random.InCube(20.0), random.InCube(0.5)};
    const double in_scene = Power(F_W, workspace.ToScene(V_D));
    const double on_hand = Power(workspace.ToDevice(F_W), V_D);
    ASSERT_NEAR(on_hand, in_scene / workspace.scale, 1e-12 * (1.0 + std::abs(on_hand)));
    ASSERT_NEAR(workspace.ToDevice(F_W).force.norm(), F_W.force.norm(), 1e-12);
  }
}

/// Moving once round a loop through a spring in the scene that couples translation and rotation by
/// a lever does no work on the hand, at any scale.
TEST(Workspace, KeepsAConservativeSceneConservative) {
  test::Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Workspace workspace = Any(random);
    const Vec3 lever = random.InCube(0.1);
    const auto wrench_at = [&](const Pose& X_WT) {
      const Vec3 arm = X_WT.q * lever;
      const Vec3 force = -1000.0 * (X_WT.p + arm - workspace.X_WD.p);
      return Wrench{force, arm.cross(force)};
    };
    const auto pose_at = [&](double u) {
      const double t = 2.0 * M_PI * u;
      return Pose{Vec3(0.01 * std::sin(t), 0.02 * std::cos(t), 0.01 * std::sin(2.0 * t)),
                  RotationExp(Vec3(0.4 * std::cos(t), 0.3 * std::sin(t), 0.2))};
    };
    const int steps = 4000;
    double work = 0.0, gross = 0.0;
    for (int i = 0; i < steps; ++i) {
      const Pose a = pose_at(double(i) / steps), b = pose_at(double(i + 1) / steps);
      const Twist step{b.p - a.p, RotationLog(b.q * a.q.conjugate())};
      const Wrench fa = workspace.ToDevice(wrench_at(workspace.ToScene(a)));
      const Wrench fb = workspace.ToDevice(wrench_at(workspace.ToScene(b)));
      const double done = 0.5 * (Power(fa, step) + Power(fb, step));
      work += done;
      gross += std::abs(done);
    }
    ASSERT_LT(std::abs(work), 1e-5 * gross) << workspace.scale;
  }
}

class WorkspaceFileTest : public testing::Test {
 protected:
  Workspace Load(const std::string& text) {
    std::ofstream(file_) << text;
    return Workspace::Load(file_);
  }
  std::string Complaint(const std::string& text) {
    return test::ComplaintOf([&] { Load(text); });
  }
  const test::Folder folder_;
  const std::string file_ = folder_ / "workspace.json";
};

TEST_F(WorkspaceFileTest, IsReadInItsUnits) {
  const Workspace workspace = Load(R"({
    "description": "an arm beside a screen",
    "centre_mm": [10, 20, 30],
    "device_in_scene": {"position_mm": [0, 0, 100],
                        "rotation_deg": {"axis": [0, 1, 0], "angle": 90}},
    "tool_in_handle": {"quaternion_wxyz": [0, 1, 0, 0]},
    "scale": 2.5,
    "clutch": {"button": 1},
    "walls": {"margin_mm": 15, "force_N": 2}
  })");
  EXPECT_LT((*workspace.centre_m - Vec3(0.01, 0.02, 0.03)).norm(), 1e-15);
  EXPECT_LT((workspace.X_WD * Vec3(0, 0, 1) - Vec3(1, 0, 0.1)).norm(), 1e-12);
  EXPECT_EQ(workspace.q_HT.x(), 1.0);
  EXPECT_EQ(workspace.scale, 2.5);
  EXPECT_EQ(workspace.clutch_button, 1);
  EXPECT_EQ(workspace.wall_margin_m, 0.015);
  EXPECT_EQ(workspace.wall_force_N, 2.0);
}

TEST_F(WorkspaceFileTest, IsAsTheReadmeShowsIt) {
  const std::string readme = ReadWholeFile(std::string(PALPATE_SOURCE_DIR) + "/devices/README.md");
  const std::size_t begin = readme.find("```json\n") + 8;
  const Workspace workspace = Load(readme.substr(begin, readme.find("```", begin) - begin));
  EXPECT_EQ(workspace.scale, 2.0);
  EXPECT_EQ(workspace.clutch_button, 0);
}

TEST_F(WorkspaceFileTest, MayBeEmpty) {
  const Workspace workspace = Load("{}");
  EXPECT_EQ(workspace.scale, 1.0);
  EXPECT_FALSE(workspace.clutch_button);
  EXPECT_FALSE(workspace.wall_force_N);
}

TEST_F(WorkspaceFileTest, NamesTheFieldThatIsWrong) {
  EXPECT_THAT(Complaint(R"({"scales": 2})"), HasSubstr("did you mean \"scale\""));
  EXPECT_THAT(Complaint("{\n\"scale\": 20}"), HasSubstr(file_ + ":2: scale: 20"));
  EXPECT_THAT(Complaint(R"({"scale": 0})"), HasSubstr("from 0.05 to 10"));
  EXPECT_THAT(Complaint(R"({"clutch": {}})"), HasSubstr("clutch: button is missing"));
  EXPECT_THAT(Complaint(R"({"clutch": {"button": 32}})"), HasSubstr("clutch.button"));
  EXPECT_THAT(Complaint(R"({"walls": {"force_N": -1}})"), HasSubstr("walls.force_N"));
  EXPECT_THAT(Complaint(R"({"tool_in_handle": {"position_mm": [0, 0, 1]}})"),
              HasSubstr("tool_in_handle.position_mm"));
  EXPECT_THAT(Complaint("nonsense"), HasSubstr("not JSON"));
  EXPECT_THROW(Workspace::Load("/nowhere/workspace.json"), Error);
}

constexpr double kMargin = 0.010;
constexpr double kEnd = 3.0;
const Vec3 kReach(0.4, 0.3, 0.2);

WorkspaceWalls Walls() {
  return WorkspaceWalls(Vec3::Zero(), kReach, kMargin, kEnd);
}

TEST(WorkspaceWalls, AreNotThereInside) {
  test::Random random(7);
  const Vec3 half = 0.5 * kReach - Vec3::Constant(kMargin);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 p = random.InCube(1.0).cwiseProduct(half);
    ASSERT_EQ(Walls().Force(p, random.InCube(2.0)), Vec3::Zero());
  }
}

TEST(WorkspaceWalls, PushBackAlongEachAxisAndReachTheirForceAtTheEnd) {
  EXPECT_LT((Walls().Force(0.5 * kReach, Vec3::Zero()) + Vec3::Constant(kEnd)).norm(), 1e-12);
  EXPECT_LT((Walls().Force(-0.5 * kReach, Vec3::Zero()) - Vec3::Constant(kEnd)).norm(), 1e-12);
  EXPECT_NEAR(Walls().Force(Vec3(0.195, 0, 0), Vec3::Zero()).x(), -0.5 * kEnd, 1e-12);
}

TEST(WorkspaceWalls, NeverPullOutwardsNeverJumpAndAreBounded) {
  test::Random random(8);
  // Steepest slopes: twice the end's force over the margin, and the end's force over the fade
  // speed.
  const double per_metre = 2.0 * kEnd / kMargin;
  const double per_speed = kEnd / WorkspaceWalls::kFadeSpeed_m_s;
  for (int i = 0; i < 100'000; ++i) {
    const Vec3 p = random.InCube(0.25), v = random.InCube(1.0);
    const Vec3 dp = random.InCube(1e-4), dv = random.InCube(1e-3);
    const Vec3 F = Walls().Force(p, v);
    const Vec3 change = Walls().Force(p + dp, v + dv) - F;
    for (int k = 0; k < 3; ++k) {
      ASSERT_LE(F[k] * p[k], 0.0);
      ASSERT_LE(std::abs(F[k]), 2.0 * kEnd + 1e-12);
      ASSERT_LE(std::abs(change[k]),
                per_metre * std::abs(dp[k]) + per_speed * std::abs(dv[k]) + 1e-12);
    }
  }
}

/// On any path that begins inside, the walls never give out net energy.
TEST(WorkspaceWalls, GiveBackNoMoreThanWasPutIn) {
  test::Random random(9);
  const double h = 1e-5;
  for (int trial = 0; trial < (test::kOptimised ? 50 : 5); ++trial) {
    const Vec3 amplitude(random.Uniform(0.15, 0.25), random.Uniform(0.1, 0.2),
                         random.Uniform(0.08, 0.15));
    const Vec3 frequency(random.Uniform(0.5, 8.0), random.Uniform(0.5, 8.0),
                         random.Uniform(0.5, 8.0));
    double taken = 0.0;
    for (int i = 0; i < 50'000; ++i) {
      const double t = h * (i + 0.5);
      Vec3 p, v;
      for (int k = 0; k < 3; ++k) {
        p[k] = amplitude[k] * std::sin(frequency[k] * t);
        v[k] = amplitude[k] * frequency[k] * std::cos(frequency[k] * t);
      }
      taken += h * Walls().Force(p, v).dot(v);
      ASSERT_LE(taken, 1e-9);
    }
  }
}

TEST(WorkspaceWalls, RefuseAMarginThatLeavesNothing) {
  EXPECT_THROW(WorkspaceWalls(Vec3::Zero(), kReach, 0.1, kEnd), Error);
}

/// In a loop with a frictionless arm, sampled at 1 kHz by its encoders: whenever the handle comes
/// back from a wall it is no faster than it went in.
TEST(WorkspaceWalls, TakeEnergyFromAnArmThatIsThrownAtThem) {
  for (PhantomSheet sheet : PhantomSheets()) {
    SCOPED_TRACE(sheet.name);
    sheet.dynamics.coulomb_force_N = sheet.dynamics.viscous_N_s_m = 0.0;
    auto inside = std::make_unique<SimulatedPhantom>(sheet, std::nullopt, Pose{});
    SimulatedPhantom* arm = inside.get();
    WorkspaceDevice device(std::move(inside), Workspace{});
    device.Read();
    OpenLimiter limiter;
    // Within what the end's force stops over the margin.
    const double speed =
        0.8 * std::sqrt(0.010 * sheet.info.continuous_force_N / sheet.dynamics.mass_kg);
    while (arm->velocity().v.z() < speed) device.Apply(limiter.Pass({Vec3::UnitZ(), Vec3::Zero()}));
    double energy = arm->kinetic_energy_J();
    const double first = energy;
    int bounces = 0;
    const double wall = 0.5 * sheet.info.workspace_m.z() - 0.010;
    bool was_free = true;
    for (int i = 0; i < 20'000; ++i) {
      device.Read();
      Wrench contact, led;
      device.Shape(contact, led);
      const LimitedWrench applied = limiter.Pass(contact);
      ASSERT_EQ(applied.wrench().force, contact.force);
      device.Apply(applied);
      const double z = std::abs(arm->pose().p.z());
      ASSERT_LT(z, wall + 0.010);  // the stop
      const bool free = z < wall;
      if (free && !was_free) {
        ++bounces;
        ASSERT_LE(arm->kinetic_energy_J(), energy);
        energy = arm->kinetic_energy_J();
      }
      was_free = free;
    }
    EXPECT_GE(bounces, 3);
    EXPECT_LT(energy, 0.5 * first);
  }
}

TEST(WorkspaceDevice, ShowsTheDeviceInTheScenesUnits) {
  Workspace workspace;
  workspace.scale = 4.0;
  const DeviceInfo raw = PhantomPremium30().info;
  const DeviceInfo seen = Pair(workspace).device->info();
  EXPECT_EQ(seen.max_force_N, raw.max_force_N);
  EXPECT_EQ(seen.max_torque_Nm, 4.0 * raw.max_torque_Nm);
  EXPECT_EQ(seen.workspace_m, 4.0 * raw.workspace_m);
  EXPECT_EQ(seen.position_resolution_m, 4.0 * raw.position_resolution_m);
  EXPECT_EQ(seen.max_stiffness_N_m, raw.max_stiffness_N_m / 4.0);
}

TEST(WorkspaceDevice, AsksNoMoreOfTheDeviceThanItsLimits) {
  test::Random random(10);
  const DeviceInfo raw = PhantomPremium30().info;
  for (int i = 0; i < 50; ++i) {
    Pair pair(Any(random));
    WrenchLimiter limiter(WrenchLimits::Of(pair.device->info()));
    limiter.Enable(true);
    LimiterInput in;
    in.wanted = {1e6 * random.Direction(), 1e6 * random.Direction()};
    in.silence_s = in.age_s = 0.0;
    in.dt_s = kTick;
    for (int k = 0; k < 400; ++k) {
      pair.device->Apply(limiter.Limit(in));
      ASSERT_LE(pair.held->applied.force.norm(), raw.max_force_N * (1 + 1e-12));
      ASSERT_LE(pair.held->applied.torque.norm(), raw.max_torque_Nm * (1 + 1e-12));
    }
    EXPECT_NEAR(pair.held->applied.torque.norm(), raw.max_torque_Nm, 1e-9);
  }
}

TEST(WorkspaceDevice, ShowsTheGraphicToolToTheDeviceInItsOwnFrame) {
  test::Random random(11);
  const Workspace workspace = Any(random);
  Pair pair(workspace);
  const Pose X_WG{random.InCube(0.3), random.Rotation()};
  const Vec3 p_HT = random.InCube(0.1);
  pair.device->SeeGraphicTool(X_WG, p_HT);
  // The reference point is the same point in either frame.
  const Vec3 in_scene = X_WG * p_HT;
  const Vec3 in_hand = pair.held->graphic * pair.held->reference;
  EXPECT_LT((workspace.ToDevice(Pose{in_scene, Quat::Identity()}).p - in_hand).norm(), 1e-12);
  EXPECT_LT((workspace.ToScene(pair.held->graphic).p - X_WG.p).norm(), 1e-12);
}

/// A hand that wanders, and presses the clutch at random.
TEST(WorkspaceDevice, NeitherJumpsNorPressesSuddenlyHoweverTheClutchIsUsed) {
  test::Random random(12);
  for (int trial = 0; trial < (test::kOptimised ? 20 : 4); ++trial) {
    Workspace workspace = Any(random);
    workspace.clutch_button = trial % 4;
    workspace.wall_force_N = 0.0;
    const std::uint32_t clutch = 1u << (trial % 4);
    Pair pair(workspace);
    const Wrench scene{Vec3(1, -2, 2), Vec3(0.1, 0.1, -0.2)};  // norms 3 N and 0.245 N m
    Twist V;
    DeviceSample before;
    Wrench felt_before;
    int presses = 0;
    for (int i = 0; i < 20'000; ++i) {
      DeviceSample& raw = pair.held->sample;
      if (i % 50 == 0) V = {random.InCube(0.3), random.InCube(2.0)};
      raw.X_WH.p += kTick * V.v;
      raw.X_WH.q = (RotationExp(kTick * V.w) * raw.X_WH.q).normalized();
      raw.V_WH = V;
      if (random.Below(100) == 0) raw.buttons ^= clutch;
      const bool held = (raw.buttons & clutch) != 0;
      const bool was_held = i > 0 && pair.device->activity() == std::string("holds the clutch");
      const DeviceSample seen = pair.device->Read();
      Wrench felt = scene, led = scene;
      pair.device->Shape(felt, led);
      if (i > 0) {
        const double step = (seen.X_WH.p - before.X_WH.p).norm();
        ASSERT_LE(step, workspace.scale * kTick * V.v.norm() * (1 + 1e-9) + 1e-12);
        if (held && was_held) {
          ASSERT_LT(step, 1e-12);
          ASSERT_EQ(seen.V_WH.v, Vec3::Zero());
        }
        ASSERT_LE(Angle(seen.X_WH.q, before.X_WH.q), kTick * V.w.norm() * (1 + 1e-6) + 1e-12);
        const double share = kTick / WorkspaceDevice::kClutchOut_s;
        ASSERT_LE((felt.force - felt_before.force).norm(), 3.0 * share * (1 + 1e-9));
        ASSERT_LE((felt.torque - felt_before.torque).norm(), 0.245 * share * (1 + 1e-9));
        ASSERT_LT((led.force - felt.force).norm(), 1e-12);  // a guide fades as the scene does
      }
      ASSERT_EQ(seen.buttons & clutch, 0u);
      presses += held && !was_held;
      before = seen;
      felt_before = felt;
    }
    EXPECT_GT(presses, 10);
  }
}

TEST(WorkspaceDevice, LetsGoOfTheForceWhileTheClutchIsHeldAndTakesItUpAgain) {
  Workspace workspace;
  workspace.clutch_button = 0;
  Pair pair(workspace);
  const Wrench scene{Vec3(0, 0, 2), Vec3(0, 0.1, 0)};
  const auto felt_after = [&](int ticks, bool held) {
    Wrench felt, led;
    for (int i = 0; i < ticks; ++i) {
      pair.held->sample.buttons = held ? 1 : 0;
      pair.device->Read();
      felt = scene;
      pair.device->Shape(felt, led);
    }
    return felt;
  };
  EXPECT_EQ(felt_after(1, false).force.z(), 2.0);
  EXPECT_EQ(felt_after(51, true).force, Vec3::Zero());
  EXPECT_STREQ(pair.device->activity(), "holds the clutch");
  EXPECT_NEAR(felt_after(100, false).force.z(), 1.0, 1e-9);
  EXPECT_NEAR(felt_after(101, false).force.z(), 2.0, 1e-9);
  EXPECT_STREQ(pair.device->activity(), "held");
}

TEST(WorkspaceDevice, MovesTheToolOnFromWhereItStoodByAsMuchAsTheHandMovesAfterwards) {
  Workspace workspace;
  workspace.clutch_button = 0;
  workspace.scale = 2.0;
  Pair pair(workspace);
  const auto tool_at = [&](const Vec3& hand, bool held) {
    pair.held->sample.X_WH.p = hand;
    pair.held->sample.buttons = held ? 1 : 0;
    return pair.device->Read().X_WH.p;
  };
  EXPECT_EQ(tool_at(Vec3(0.05, 0, 0), false), Vec3(0.10, 0, 0));
  EXPECT_EQ(tool_at(Vec3(0.05, 0, 0), true), Vec3(0.10, 0, 0));
  EXPECT_LT((tool_at(Vec3(-0.05, 0.01, 0), true) - Vec3(0.10, 0, 0)).norm(), 1e-15);
  EXPECT_LT((tool_at(Vec3(-0.05, 0.01, 0), false) - Vec3(0.10, 0, 0)).norm(), 1e-15);
  EXPECT_LT((tool_at(Vec3(-0.04, 0.01, 0), false) - Vec3(0.12, 0, 0)).norm(), 1e-15);
}

TEST(WorkspaceDevice, KeepsItsWallsWhileTheClutchIsHeld) {
  Workspace workspace;
  workspace.clutch_button = 0;
  Pair pair(workspace);
  pair.held->sample.X_WH.p.z() = 0.5 * PhantomPremium30().info.workspace_m.z();
  pair.held->sample.buttons = 1;
  Wrench contact, led;
  for (int i = 0; i < 100; ++i) {
    pair.device->Read();
    contact = {Vec3(5, 0, 0), Vec3::Zero()};
    pair.device->Shape(contact, led);
  }
  EXPECT_LT((contact.force - Vec3(0, 0, -3.0)).norm(), 1e-9);
}

TEST(WorkspaceDevice, HasItsWallsWhereTheDeviceReachesUnlessItIsToldWhere) {
  DeviceInfo info = PhantomPremium30().info;
  info.workspace_centre_m = Vec3(0.0, 0.05, -0.02);  // an arm's zero is seldom in the middle
  const auto felt_at = [](Pair& pair, const Vec3& p_DH) {
    pair.held->sample.X_WH.p = p_DH;
    pair.device->Read();
    Wrench contact, led;
    pair.device->Shape(contact, led);
    return contact.force;
  };
  Workspace told;
  told.centre_m = Vec3(0.1, 0.0, 0.0);
  for (const Workspace& workspace : {Workspace{}, told}) {
    Pair pair(workspace, info);
    const Vec3 centre = workspace.centre_m.value_or(info.workspace_centre_m);
    EXPECT_EQ(felt_at(pair, centre), Vec3::Zero());
    for (const double side : {1.0, -1.0}) {
      for (int i = 0; i < 3; ++i) {
        const Vec3 end = centre + side * 0.5 * info.workspace_m[i] * Vec3::Unit(i);
        EXPECT_LT((felt_at(pair, end) + side * info.continuous_force_N * Vec3::Unit(i)).norm(),
                  1e-9);
      }
    }
  }
}

TEST(WorkspaceDevice, LosesTorqueWhereTheDeviceHasNone) {
  Pair pair(Workspace{}, PhantomTouch().info);
  pair.device->Read();
  Wrench contact{Vec3(1, 0, 0), Vec3(0, 0.1, 0)}, led;
  pair.device->Shape(contact, led);
  EXPECT_EQ(contact.force, Vec3(1, 0, 0));
  EXPECT_EQ(contact.torque, Vec3::Zero());
  EXPECT_EQ(pair.device->info().torque_axes, 0);
}

TEST(WorkspaceDevice, AllocatesNothingInTheLoop) {
  test::Random random(13);
  Workspace workspace = Any(random);
  workspace.clutch_button = 0;
  Pair pair(workspace);
  const LimitedWrench wrench = PassThrough({Vec3(1, 0, 0), Vec3::Zero()});
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) {
    pair.held->sample.buttons = i / 10 % 2;
    pair.device->SeeGraphicTool(pair.device->Read().X_WH, Vec3::Zero());
    Wrench contact, led;
    pair.device->Shape(contact, led);
    pair.device->Apply(wrench);
    pair.device->activity();
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate
