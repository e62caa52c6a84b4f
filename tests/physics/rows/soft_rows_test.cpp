#include "server/physics/rows/soft_rows.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "server/physics/start_pose.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::AllOf;
using test::At;
using test::Ball;
using test::Bench;
using test::Floor;
using test::Random;
using test::RandomBalls;

constexpr double kCoupling = 1000.0;  // StepParameters::stiffness

StepParameters Compliant() {
  StepParameters parameters;
  parameters.features.compliance = true;
  return parameters;
}

/// An object that is flat to 0.1 nm over a slide.
const std::vector<Ball> kGround{{Vec3(0.0, 0.0, -1e4), 1e4}};

TEST(SoftRows, PutASphereInSeriesWithTheCoupling) {
  for (const double k : {50.0, 300.0, 1000.0, 2e4}) {
    Bench bench({{Vec3::Zero(), 0.005}}, kGround, Compliant(), AllOf({.stiffness = k}));
    bench.state().X_WG = At(0.0, 0.0, 0.006);
    const double depth = 2e-3;
    const StepReport report = bench.Repeat(At(0.0, 0.0, 0.005 - depth), 20);
    const double series = kCoupling * k / (kCoupling + k);
    EXPECT_NEAR(report.wrench.force.z(), series * depth, 1e-8 * series) << k;
    EXPECT_EQ(report.faults, 0u);
    ASSERT_EQ(report.contacts, 1);
    EXPECT_EQ(report.soft_contacts, 1);
    EXPECT_EQ(report.active[0].stiffness, k);
    EXPECT_NEAR(report.active[0].force, k * report.active[0].offset, 1e-9);
    EXPECT_NEAR(report.active[0].force, report.wrench.force.z(), 1e-9);
  }
}

TEST(SoftRows, AddUpWhereTheyAreParallel) {
  // N legs on a plane, each of stiffness k: N k together.
  const int n = 12;
  std::vector<Ball> legs;
  for (int i = 0; i < n; ++i) {
    legs.push_back(
        {Vec3(0.02 * std::cos(2.0 * M_PI * i / n), 0.02 * std::sin(2.0 * M_PI * i / n), 0.0),
         0.003});
  }
  const double k = 100.0, depth = 1e-3;
  Bench bench(legs, kGround, Compliant(), AllOf({.stiffness = k}));
  bench.state().X_WG = At(0.0, 0.0, 0.004);
  const StepReport report = bench.Repeat(At(0.0, 0.0, 0.003 - depth), 50);
  EXPECT_EQ(report.soft_contacts, n);
  EXPECT_EQ(report.contacts, kMaxActiveRows);
  // Where they stand, the plane lies 0.02^2 / (2 10^4) m lower.
  const double pressed = depth - 0.02 * 0.02 / 2e4;
  EXPECT_NEAR(report.wrench.force.z(), pressed * kCoupling * n * k / (kCoupling + n * k), 1e-8);
  EXPECT_LT((report.soft_wrench.force - report.wrench.force).norm(), 1e-9);
  EXPECT_LT(report.wrench.torque.norm(), 1e-6);
}

TEST(SoftRows, TiltAToolTowardsTheirHalfBesideARigidOne) {
  // Two legs, one over a rigid half and one over a soft half of k = 200 N/m, pressed 1 mm.
  const std::vector<Ball> legs{{Vec3(0.02, 0.0, 0.0), 0.003}, {Vec3(-0.02, 0.0, 0.0), 0.003}};
  const std::vector<Ball> halves{{Vec3(0.02, 0.0, -0.01), 0.01}, {Vec3(-0.02, 0.0, -0.01), 0.01}};
  const double k = 200.0;
  Bench bench(legs, halves, Compliant(),
              {{Material{}, Material{.stiffness = k}}, [](const Vec3& c) { return c.x() < 0.0; }});
  bench.state().X_WG = At(0.0, 0.0, 0.004);
  const StepReport report = bench.Repeat(At(0.0, 0.0, 0.002), 300);
  ASSERT_EQ(report.contacts, 2);
  EXPECT_EQ(report.soft_contacts, 1);
  EXPECT_TRUE(std::isinf(report.active[0].stiffness));
  EXPECT_EQ(report.active[1].stiffness, k);
  // It turns by a and rises by l a, so that the rigid leg stays; the soft leg enters by 2 l a.
  // About the rigid leg: k_t l (d - l a) = k_r a + 2 l k 2 l a.
  const double l = 0.02, d = 1e-3;
  const double a = kCoupling * d * l / (1.0 + l * l * (kCoupling + 4.0 * k));
  EXPECT_NEAR(report.active[1].force, k * 2.0 * l * a, 2e-3);
  EXPECT_NEAR(report.wrench.force.z(), kCoupling * (d - l * a), 2e-3);
  EXPECT_NEAR(report.active[0].force, report.wrench.force.z() - report.active[1].force, 1e-5);
}

TEST(SoftRows, MeetARigidCoreWithoutAJumpAndAreNotPassedThrough) {
  // A ball enters a soft ball ever deeper, past its centre: no jump of the force or of the normal.
  const double r_tool = 0.002, r = 0.004, k = 300.0;
  Bench bench({{Vec3::Zero(), r_tool}}, {{Vec3::Zero(), r}}, Compliant(), AllOf({.stiffness = k}));
  bench.state().X_WG = At(0.0, 0.0, 0.007);
  const double step = 1e-5;
  double before = 0.0;
  for (double z = 0.007; z > -0.004; z -= step) {
    const StepReport report = bench.Step(At(0.0, 0.0, z));
    EXPECT_EQ(report.faults, 0u);
    EXPECT_GE(report.X_WG.p.z(), r_tool + (1.0 - limits::kSoftShare) * r - 1e-12) << z;
    EXPECT_LE(report.wrench.force.z() - before, 1.0001 * kCoupling * step) << z;
    EXPECT_GE(report.wrench.force.z() - before, -1e-9) << z;
    before = report.wrench.force.z();
  }
  EXPECT_NEAR(before, kCoupling * (r_tool + (1.0 - limits::kSoftShare) * r + 0.004), 0.02);
}

TEST(SoftRows, StopAToolThatIsThrustThroughAThinSoftPlate) {
  // One layer of balls, 2 mm thick, and hands at up to 0.5 m/s that move on to 20 mm behind it.
  Bench bench({{Vec3::Zero(), 0.002}}, Floor(0.02, 0.001, 0.001), Compliant(),
              AllOf({.stiffness = 100.0}));
  Random random(71);
  for (int thrust = 0; thrust < 40; ++thrust) {
    const Vec3 from(random.Uniform(-0.01, 0.01), random.Uniform(-0.01, 0.01), 0.01);
    const Vec3 to(random.Uniform(-0.01, 0.01), random.Uniform(-0.01, 0.01), -0.02);
    bench.state() = {};
    bench.state().X_WG.p = from;
    const int steps = static_cast<int>((to - from).norm() / (random.Uniform(0.05, 0.5) * 1e-3));
    for (int i = 0; i <= steps + 100; ++i) {
      Pose X;
      X.p = from + std::min(1.0, static_cast<double>(i) / steps) * (to - from);
      ASSERT_GT(bench.Step(X).X_WG.p.z(), 0.0) << thrust;
    }
  }
}

TEST(SoftRows, AddUpToTheWrenchWithRigidOnesAndAllocateNothing) {
  Random random(72);
  // A soft layer 1 mm above a rigid one.
  std::vector<Ball> layers = Floor(0.06, 0.004, 0.004);
  for (const Ball& ball : Floor(0.06, 0.004, 0.003)) {
    layers.push_back({ball.center + Vec3(0.0, 0.0, 0.001), ball.radius});
  }
  Bench bench(
      RandomBalls(random, 100, 0.02, 0.004), layers, Compliant(),
      {{Material{}, Material{.stiffness = 20.0}}, [](const Vec3& c) { return c.z() > -0.003; }});
  bench.state().X_WG = At(0.0, 0.0, 0.05);
  bench.Step(At(0.0, 0.0, 0.05));
  int both = 0;
  for (int i = 0; i < 3000; ++i) {
    Pose X = At(1e-5 * i - 0.015, 5e-3 * std::sin(i * 1e-2), 0.05 - 1.5e-5 * i);
    X.q = RotationExp(Vec3(2e-4 * i, 1e-4 * i, 0.0));
    const auto allocations = test::AllocationsOfThisThread();
    const StepReport report = bench.Step(X);
    ASSERT_EQ(test::AllocationsOfThisThread(), allocations);
    ASSERT_EQ(report.faults & ~kFaultTargetFar, 0u) << i;
    Vec3 force = report.soft_wrench.force, torque = report.soft_wrench.torque;
    int rigid = 0;
    for (int c = 0; c < report.contacts; ++c) {
      const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
      if (!std::isinf(row.stiffness)) continue;
      ++rigid;
      force += row.force * row.normal;
      torque += row.force * row.lever_cross_normal;
    }
    EXPECT_LT((force - report.wrench.force).norm(), 1e-6) << i;
    EXPECT_LT((torque - report.wrench.torque).norm(), 5e-3 * (1.0 + torque.norm())) << i;
    both += rigid > 0 && report.soft_contacts > 0;
  }
  EXPECT_GT(both, 100);
}

TEST(SoftRows, CountForNothingWhereComplianceIsNotDeclared) {
  Bench rigid({{Vec3::Zero(), 0.005}}, kGround);
  Bench undeclared({{Vec3::Zero(), 0.005}}, kGround, {}, AllOf({.stiffness = 100.0}));
  EXPECT_FALSE(undeclared.model().yields());
  rigid.state().X_WG = undeclared.state().X_WG = At(0.0, 0.0, 0.006);
  for (int i = 0; i < 100; ++i) {
    const Pose X = At(1e-5 * i, 0.0, 0.006 - 4e-5 * i);
    EXPECT_EQ(rigid.Step(X).wrench.force, undeclared.Step(X).wrench.force);
  }
}

TEST(SoftRows, LetAToolStartWhereItHasEnteredThem) {
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3::Zero(), 0.02}}, Compliant(),
              AllOf({.stiffness = 100.0}));
  const Pose shallow = At(0.0, 0.0, 0.02);
  EXPECT_EQ(ResolveStart(bench.model(), shallow, bench.workspace()).depth, 0.0);
  EXPECT_GT(ResolveStart(bench.model(), At(0.0, 0.0, 0.012), bench.workspace()).depth, 1e-3);
}

TEST(SoftRows, RefuseAStiffnessThatIsNotPositive) {
  EXPECT_THROW(Bench({{Vec3::Zero(), 0.005}}, kGround, Compliant(), AllOf({.stiffness = 0.0})),
               Error);
}

}  // namespace
}  // namespace palpate
