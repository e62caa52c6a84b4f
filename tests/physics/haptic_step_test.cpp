#include "server/physics/haptic_step.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "server/physics/simd/kernels.h"
#include "tests/physics/contact/contact_scenes.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/optimised.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::At;
using test::Ball;
using test::Bench;
using test::Floor;
using test::Random;
using test::RandomBalls;

std::vector<Ball> OneBall(double radius) {
  return {{Vec3::Zero(), radius}};
}

TEST(HapticStep, GivesExactlyZeroInFreeSpace) {
  Random random(51);
  Bench bench(RandomBalls(random, 50, 0.02, 0.003), Floor(0.05, 0.005, 0.005));
  for (int i = 0; i < 1000; ++i) {
    Pose X = At(0.0, 0.0, 0.1);
    X.p += random.InCube(0.03);
    X.q = random.Rotation();
    bench.state().X_WG = X;
    X.p += random.InCube(1e-4);
    const StepReport report = bench.Step(X);
    EXPECT_EQ(report.wrench.force, Vec3::Zero());
    EXPECT_EQ(report.wrench.torque, Vec3::Zero());
    EXPECT_EQ(report.X_WG.p, X.p);
    EXPECT_EQ(report.faults, 0u);
  }
}

TEST(HapticStep, RestsASphereOnASphereAsGeometrySays) {
  const double r_tool = 0.005, r_object = 0.02, depth = 1e-3;
  Bench bench(OneBall(r_tool), OneBall(r_object));
  EXPECT_TRUE(bench.model().is_ball());
  Random random(52);
  for (int candidate = 0; candidate < 100; ++candidate) {
    const Vec3 n = random.Direction();
    bench.state() = {};
    bench.state().X_WG.p = (r_tool + r_object + 0.01) * n;
    Pose X;
    X.p = (r_tool + r_object - depth) * n;
    X.q = random.Rotation();
    const StepReport report = bench.Repeat(X, 10);
    EXPECT_LT((report.wrench.force - 1000.0 * depth * n).norm(), 1e-9);
    EXPECT_EQ(report.wrench.torque, Vec3::Zero());
    EXPECT_LT((report.X_WG.p - (r_tool + r_object) * n).norm(), 1e-12);
    ASSERT_EQ(report.contacts, 1);
    EXPECT_NEAR(report.active[0].force, 1000.0 * depth, 1e-9);
    EXPECT_LT((report.active[0].contact_W - r_object * n).norm(), 1e-12);
  }
}

TEST(HapticStep, SlidesASphereOnAPlaneWithTheForceOfItsDepth) {
  // A ball of radius 10 km is flat to 0.1 nm over the slide.
  Bench bench(OneBall(0.005), {{Vec3(0.0, 0.0, -1e4), 1e4}});
  bench.state().X_WG = At(0.0, 0.0, 0.006);
  for (int i = 0; i < 1000; ++i) {
    const StepReport report = bench.Step(At(1e-6 * i, 0.0, 0.005 - 2e-3));
    if (i < 20) continue;
    EXPECT_NEAR(report.wrench.force.z(), 2.0, 1e-6);
    EXPECT_NEAR(report.wrench.force.x(), 0.0, 1e-6);
  }
}

TEST(HapticStep, RestsAThreeLeggedToolFlat) {
  const double r = 0.003;
  const std::vector<Ball> legs{
      {Vec3(0.03, 0.0, 0.0), r}, {Vec3(-0.015, 0.026, 0.0), r}, {Vec3(-0.015, -0.026, 0.0), r}};
  Bench bench(legs, {{Vec3(0.0, 0.0, -1e4), 1e4}});
  EXPECT_FALSE(bench.model().is_ball());
  bench.state().X_WG = At(0.0, 0.0, 0.004);
  // Pressed 1 mm deep and tilted by 10 mrad about x: it stays flat, and the torque is the spring's.
  Pose X = At(0.0, 0.0, r - 1e-3);
  X.q = RotationExp(Vec3(0.01, 0.0, 0.0));
  const StepReport report = bench.Repeat(X, 200);
  EXPECT_NEAR(report.wrench.force.z(), 1.0, 1e-4);
  EXPECT_NEAR(report.wrench.torque.x(), -0.01, 1e-4);
  EXPECT_LT(report.X_WG.q.vec().norm(), 1e-5);
  EXPECT_EQ(report.contacts, 3);
  double sum = 0.0;
  for (int i = 0; i < report.contacts; ++i) sum += report.active[static_cast<std::size_t>(i)].force;
  EXPECT_NEAR(sum, 1.0, 1e-4);
}

TEST(HapticStep, ForcesOfTheContactsAddUpToTheWrench) {
  Random random(53);
  Bench bench(RandomBalls(random, 100, 0.02, 0.004), Floor(0.06, 0.004, 0.004));
  bench.state().X_WG = At(0.0, 0.0, 0.05);
  int loaded = 0;
  for (int i = 0; i < 3000; ++i) {
    Pose X = At(1e-5 * i - 0.015, 5e-3 * std::sin(i * 1e-2), 0.05 - 1.5e-5 * i);
    X.q = RotationExp(Vec3(2e-4 * i, 1e-4 * i, 0.0));
    const StepReport report = bench.Step(X);
    ASSERT_EQ(report.faults & ~kFaultTargetFar, 0u) << i;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (int c = 0; c < report.contacts; ++c) {
      const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
      force += row.force * row.normal;
      torque += row.force * row.lever_cross_normal;
    }
    EXPECT_LT((force - report.wrench.force).norm(), 1e-6) << i;
    // Equal to first order: the QP's torque is linear in the step, the spring's a Log of a product.
    EXPECT_LT((torque - report.wrench.torque).norm(), 5e-3 * (1.0 + torque.norm())) << i;
    loaded += report.contacts > 0;
  }
  EXPECT_GT(loaded, 500);
}

TEST(HapticStep, ReportsContactsAsTheyAreAtTheReportedPose) {
  Random random(61);
  Bench bench(RandomBalls(random, 100, 0.02, 0.004), Floor(0.06, 0.004, 0.004));
  bench.state().X_WG = At(0.0, 0.0, 0.05);
  int contacts = 0;
  for (int i = 0; i < 3000; ++i) {
    Pose X = At(2e-5 * i - 0.03, 5e-3 * std::sin(i * 1e-2), 0.05 - 1.5e-5 * i);
    X.q = RotationExp(Vec3(2e-4 * i, 1e-4 * i, 0.0));
    const StepReport report = bench.Step(X);
    for (int c = 0; c < report.contacts; ++c) {
      const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
      const auto tool = static_cast<std::size_t>(row.id.a);
      const auto object = static_cast<std::size_t>(row.id.b);
      const LeafSphere& t = bench.model().tool().leaves[tool];
      const LeafSphere& o = bench.model().objects().leaves[object];
      const Vec3 c_T = report.X_WG * (bench.model().reference() + Vec3(t.x, t.y, t.z));
      const double gap = (c_T - Vec3(o.x, o.y, o.z)).norm() - t.radius - o.radius;
      // Exact except for linearisation: the normal turns by step / distance.
      ASSERT_NEAR(row.offset, -gap, 5e-5) << i;
      ASSERT_LT((row.contact_W - c_T).norm(), t.radius * (1.0 + 1e-12)) << i;
      if ((report.faults & kFaultTargetFar) == 0) {
        ASSERT_NEAR(row.offset, 0.0, 1e-9) << i;
      }
      ++contacts;
    }
  }
  EXPECT_GT(contacts, 1000);
}

TEST(HapticStep, NeverEntersAnObjectWhateverTheHandDoes) {
  Random random(54);
  Bench bench(RandomBalls(random, 60, 0.02, 0.004), RandomBalls(random, 200, 0.05, 0.005));
  bench.state().X_WG = At(0.0, 0.0, 0.15);
  ASSERT_EQ(bench.Penetration(), 0.0);
  Pose X = At(0.0, 0.0, 0.15), goal = X;
  double deepest = 0.0;
  int unsolved = 0;
  for (int i = 0; i < (test::kOptimised ? 20000 : 4000); ++i) {
    if (i % 200 == 0) {
      goal.p = random.InCube(0.08);
      goal.q = random.Rotation();
      if (i % 1000 == 0) X = goal;  // a jump
    }
    X.p += 0.02 * (goal.p - X.p);
    X.q = X.q.slerp(0.02, goal.q);
    const StepReport report = bench.Step(X);
    unsolved += (report.faults & kFaultUnsolved) != 0;
    ASSERT_TRUE(report.wrench.force.allFinite() && report.wrench.torque.allFinite());
    deepest = std::max(deepest, bench.Penetration());
  }
  EXPECT_EQ(unsolved, 0);
  EXPECT_LT(deepest, 1e-6);
}

TEST(HapticStep, DoesNotCrossAThinPlate) {
  // 0.5 mm thick, pressed 20 mm deep and slid over its rim at 0.5 m/s.
  std::vector<Ball> plate;
  for (double x = -0.02; x <= 0.02; x += 0.2e-3) {
    for (double y = -0.004; y <= 0.004; y += 0.2e-3) plate.push_back({Vec3(x, y, 0.0), 0.25e-3});
  }
  Bench bench(OneBall(0.002), plate);
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  for (int i = 0; i < 100; ++i) {
    const StepReport report = bench.Step(At(0.0, 0.0, 0.01 - 0.5e-3 * std::min(i, 60)));
    ASSERT_GT(report.X_WG.p.z(), 0.0022);
    ASSERT_LT(bench.Penetration(), 1e-9);
  }
  for (int i = 0; i < 200; ++i) {  // over the rim and round the plate to the hand
    bench.Step(At(0.5e-3 * i, 0.0, -0.02));
    ASSERT_LT(bench.Penetration(), 1e-6);
  }
  EXPECT_LT(bench.state().X_WG.p.z(), 0.0);
}

TEST(HapticStep, FollowsAJumpWithoutForceInFreeSpace) {
  Random random(55);
  Bench bench(RandomBalls(random, 30, 0.02, 0.003), Floor(0.05, 0.005, 0.005));
  bench.state().X_WG = At(0.0, 0.0, 0.2);
  Pose X = At(0.05, 0.0, 0.2);
  X.q = RotationExp(Vec3(0.0, 1.5707963, 0.0));
  int far = 0;
  for (int i = 0; i < 100; ++i) {
    const StepReport report = bench.Step(X);
    EXPECT_EQ(report.wrench.force, Vec3::Zero());
    EXPECT_EQ(report.wrench.torque, Vec3::Zero());
    far += (report.faults & kFaultTargetFar) != 0;
  }
  EXPECT_GT(far, 0);
  EXPECT_EQ(bench.state().X_WG.p, X.p);
}

TEST(HapticStep, HoldsStillAndSaysSoOnABadPose) {
  Bench bench(OneBall(0.005), OneBall(0.02));
  bench.state().X_WG = At(0.0, 0.0, 0.03);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  std::vector<Pose> bad(4, At(0.0, 0.0, 0.02));
  bad[0].p.x() = nan;
  bad[1].p.z() = -inf;
  bad[2].q = Quat(0.0, 0.0, 0.0, 0.0);
  bad[3].q.w() = nan;
  for (const Pose& X : bad) {
    const StepReport report = bench.Step(X);
    EXPECT_EQ(report.faults, static_cast<std::uint32_t>(kFaultBadPose));
    EXPECT_EQ(report.wrench.force, Vec3::Zero());
    EXPECT_EQ(report.X_WG.p, Vec3(0.0, 0.0, 0.03));
  }
}

/// While it lives, makes the n-th call of a QP solver fail: by the iteration limit, or by a NaN.
class FailingSolver {
 public:
  explicit FailingSolver(int call, bool with_nan) : spoilt_(ActiveKernels()) {
    real_ = &ActiveKernels();
    left_ = call;
    with_nan_ = with_nan;
    spoilt_.solve = [](auto... args) { return Spoil(real_->solve(args...)); };
    UseKernels(spoilt_);
  }
  ~FailingSolver() { UseKernels(*real_); }
  bool has_failed() const { return left_ <= 0; }

 private:
  static QpResult Spoil(QpResult result) {
    if (--left_ != 0) return result;
    if (with_nan_) {
      result.x[0] = std::numeric_limits<double>::quiet_NaN();
    } else {
      result.status = QpStatus::kIterationLimit;
    }
    return result;
  }
  Kernels spoilt_;
  static inline const Kernels* real_ = nullptr;
  static inline int left_ = 0;
  static inline bool with_nan_ = false;
};

// Whichever of its QPs fails.
TEST(HapticStep, StaysWhereItIsWhereASolverFails) {
  Scene box = test::MeshScene(MakeBox(Vec3(0.02, 0.02, 0.01)), MakeBox(Vec3(0.05, 0.05, 0.02)));
  Scene rubbing = box, soft = box;
  rubbing.objects[0].materials = {Material{.static_friction = 0.5, .dynamic_friction = 0.3}};
  rubbing.features.friction = FrictionModel::kCoulomb;
  soft.objects[0].materials = {Material{.stiffness = 2000.0}};
  soft.features.compliance = true;
  const Scene spheres =
      test::MakeScene(box.tools[0].mesh, 64, box.objects[0].mesh, 64, ContactModel::kSpheres);
  const Scene ball = test::MakeScene(MakeSphere(0.005, 320), 1, MakeBox(Vec3(0.05, 0.05, 0.02)), 64,
                                     ContactModel::kSurface);
  const std::pair<const char*, const Scene*> scenes[] = {{"box", &box},
                                                         {"rubbing", &rubbing},
                                                         {"soft", &soft},
                                                         {"spheres", &spheres},
                                                         {"ball", &ball}};
  for (const auto& [name, scene] : scenes) {
    const HapticModel model = MakeModel(*scene, scene->tools[0], MakeObjects(*scene));
    const test::MeshOracle oracle(*scene);
    const bool meshes = !model.bodies().empty();
    StepWorkspace workspace(model);
    StepState state(model);
    state.X_WG = state.X_WH = At(0.017, 0.0, 0.0152);
    int failed = 0;
    for (int i = 0; i < 20; ++i) {
      // Down onto an edge and over it, 0.2 mm per step, while turning.
      Pose X_WH = At(0.017 + 2e-4 * i, 0.0, 0.0150 - 2e-4 * i);
      X_WH.q = RotationExp(Vec3(0.0, 2e-3 * i, 1e-3 * i));
      for (const bool with_nan : {false, true}) {
        for (int call = 1;; ++call) {
          StepState spoilt = state;
          StepReport report;
          {
            const FailingSolver solver(call, with_nan);
            report = HapticStep(model, X_WH, spoilt, workspace);
            if (!solver.has_failed()) break;
          }
          SCOPED_TRACE(testing::Message() << name << ", step " << i << ", call " << call
                                          << (with_nan ? ", no number" : ""));
          ASSERT_TRUE(report.wrench.force.allFinite() && report.wrench.torque.allFinite());
          ASSERT_TRUE(report.X_WG.p.allFinite());
          if (meshes) {
            ASSERT_FALSE(oracle.Meet(report.X_WG));
          }
          if ((report.faults & kFaultUnsolved) != 0) {
            ++failed;
            // The tool stays where it was before the sub-step, and the spring pulls from there.
            // (Between meshes it may have moved before the force was computed.)
            if (!meshes && report.diagnostics.substeps == 1) {
              ASSERT_LT((report.X_WG.p - state.X_WG.p).norm(), 1e-15);
            }
            const Vec3 stretch = report.X_WG * model.reference() - X_WH * model.reference();
            ASSERT_LT((report.wrench.force - 1e3 * stretch).norm(), 1e-9);
            ASSERT_EQ(report.contacts + report.soft_contacts, 0);
            ASSERT_EQ(report.faults & kFaultTargetFar, 0u);
          }
          // The next steps go on as if nothing had happened.
          StepState same = state;
          for (int k = 0; k < 30; ++k) {
            report = HapticStep(model, X_WH, spoilt, workspace);
            const StepReport expected = HapticStep(model, X_WH, same, workspace);
            if (k < 29) continue;
            // With friction, where the tool sticks depends on its path.
            if (scene != &rubbing) {
              ASSERT_LT((report.wrench.force - expected.wrench.force).norm(), 2e-3);
            }
            ASSERT_EQ(report.faults, 0u);
          }
        }
      }
      HapticStep(model, X_WH, state, workspace);
    }
    EXPECT_GT(failed, 20) << name;
  }
}

// Springs that no arm has: the results are finite all the same.
TEST(HapticStep, SaysUnsolvedWhereTheSpringsForceIsNoNumber) {
  StepParameters parameters;
  parameters.stiffness = 1e308;
  parameters.torsional_stiffness = 1e305;
  Bench bench(OneBall(0.005), {{Vec3(0.0, 0.0, -1e4), 1e4}}, parameters);
  bench.state().X_WG = At(0.0, 0.0, 0.006);
  bench.Step(At(0.0, 0.0, 0.0055));
  const StepReport report = bench.Step(At(0.0, 0.0, -20.0));
  EXPECT_EQ(report.faults & kFaultUnsolved, static_cast<std::uint32_t>(kFaultUnsolved));
  EXPECT_EQ(report.wrench.force, Vec3::Zero());
  EXPECT_LT((report.X_WG.p - Vec3(0.0, 0.0, 0.0055)).norm(), 1e-12);
  EXPECT_EQ(bench.Step(At(0.0, 0.0, 0.0055)).faults, 0u);
}

TEST(HapticStep, TakesBothSignsOfAQuaternionForTheSamePose) {
  Random random(56);
  const auto tool = RandomBalls(random, 40, 0.02, 0.004);
  Bench a(tool, Floor(0.05, 0.004, 0.004)), b(tool, Floor(0.05, 0.004, 0.004));
  a.state().X_WG = b.state().X_WG = At(0.0, 0.0, 0.04);
  for (int i = 0; i < 2000; ++i) {
    Pose X = At(0.0, 0.0, 0.04 - 2e-5 * i);
    X.q = RotationExp(Vec3(0.0, 2e-3 * i, 0.0));  // through 90 degrees and beyond
    Pose minus = X;
    minus.q.coeffs() = -minus.q.coeffs();
    const StepReport ra = a.Step(X), rb = b.Step(i % 2 == 0 ? X : minus);
    ASSERT_LT((ra.wrench.force - rb.wrench.force).norm(), 1e-9);
    ASSERT_LT((ra.wrench.torque - rb.wrench.torque).norm(), 1e-9);
  }
}

TEST(HapticStep, EndsAJamWithoutAForceBeyondTheSpring) {
  // In a slot narrower than the ball no pose satisfies both walls.
  Bench bench(OneBall(0.01), {{Vec3(0.03, 0.0, 0.0), 0.0202}, {Vec3(-0.03, 0.0, 0.0), 0.0202}});
  const StepReport report = bench.Repeat(At(0.0, 0.0, 0.0), 5);
  EXPECT_TRUE(report.wrench.force.allFinite());
  EXPECT_NE(report.faults & kFaultJammed, 0u);
  EXPECT_LT(report.wrench.force.norm(), 1.0);
}

TEST(HapticStep, GoesNoFartherThanItsRowsSufficeFor) {
  Random random(57);
  const std::vector<Ball> tool = RandomBalls(random, 200, 0.01, 0.004);
  const std::vector<Ball> floor = Floor(0.05, 0.002, 0.004);
  Vec3 force[2];
  int full = 0;
  for (const int max_rows : {64, limits::kMaxRows}) {
    StepParameters parameters;
    parameters.max_rows = max_rows;
    Bench bench(tool, floor, parameters);
    bench.state().X_WG = At(0.0, 0.0, 0.03);
    for (int i = 0; i < 400; ++i) {
      const StepReport report =
          bench.Step(At(1e-4 * std::min(i, 100), 0.0, 0.03 - 2e-4 * std::min(i, 100)));
      ASSERT_LT(bench.Penetration(), 1e-6) << max_rows << ' ' << i;
      full += (report.faults & kFaultRowsFull) != 0;
      force[max_rows == 64 ? 0 : 1] = report.wrench.force;
    }
  }
  EXPECT_EQ(full, 0);
  EXPECT_LT((force[0] - force[1]).norm(), 1e-6);
}

TEST(HapticStep, SaysWhenRowsDoNotFitWithinTheNarrowestBoundsAndCanLeave) {
  StepParameters parameters;
  parameters.max_rows = 2;
  const double r = 0.003;
  const std::vector<Ball> legs{
      {Vec3(0.03, 0.0, 0.0), r}, {Vec3(-0.015, 0.026, 0.0), r}, {Vec3(-0.015, -0.026, 0.0), r}};
  Bench bench(legs, {{Vec3(0.0, 0.0, -1e4), 1e4}}, parameters);
  bench.state().X_WG = At(0.0, 0.0, 0.004);
  const StepReport report = bench.Repeat(At(0.0, 0.0, 0.001), 20);
  EXPECT_NE(report.faults & kFaultRowsFull, 0u);
  // One sub-step of 2 um in each cycle may neglect a leg.
  EXPECT_LT(bench.Penetration(), 20 * 2.1e-6);
  EXPECT_LE(report.wrench.force.norm(), 1000.0 * 2e-3 + 1.0);
  EXPECT_LT(bench.Repeat(At(0.0, 0.0, 0.01), 100).wrench.force.norm(), 1e-6);
}

TEST(HapticStep, AllocatesNothing) {
  Random random(58);
  Bench bench(RandomBalls(random, 200, 0.02, 0.004), RandomBalls(random, 500, 0.05, 0.004));
  bench.state().X_WG = At(0.0, 0.0, 0.2);
  bench.Step(At(0.0, 0.0, 0.2));
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 1000; ++i) bench.Step(At(0.0, 0.0, 0.2 - 2e-4 * i));
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate
