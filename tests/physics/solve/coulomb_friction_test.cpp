#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "server/physics/solve/stages.h"
#include "tests/physics/solve/friction_bench.h"
#include "tests/support/optimised.h"

namespace palpate {
namespace {

/// AddCoulombFriction for a lone tool.
void AddFriction(StepContext& context, Optimum& optimum) {
  StepContext* const alone[] = {&context};
  context.advance.optimum = optimum;
  AddCoulombFriction(alone);
  optimum = context.advance.optimum;
}

using namespace test;

constexpr double kStiffness = 1000.0;

/// True in every step: friction lies in its cone, perpendicular to the normal, and forces add up.
void ExpectContactForcesAddUp(const Bench& bench, const StepReport& report, double mu_s) {
  Vec3 force = Vec3::Zero();
  for (int i = 0; i < report.contacts; ++i) {
    const ActiveRow& row = report.active[static_cast<std::size_t>(i)];
    ASSERT_GE(row.force, 0.0);
    ASSERT_LE(row.friction.norm(), mu_s * row.force + 1e-6 * (1.0 + report.wrench.force.norm()));
    ASSERT_LE(std::fabs(row.friction.dot(row.normal)), 1e-9 * (1.0 + row.force));
    force += row.force * row.normal + row.friction;
  }
  // Up to what Creep corrects, at most max_truncation.
  ASSERT_LT((force - report.wrench.force).norm(),
            kStiffness * bench.model().parameters().max_truncation + 1e-6 * force.norm());
}

INSTANTIATE_TEST_SUITE_P(BallAndBox, FrictionTool, testing::Bool(),
                         [](const auto& which) { return which.param ? "Box" : "Ball"; });

TEST_P(FrictionTool, SlidesOnAPlaneWithTheDynamicCoefficientAtAnySpeed) {
  for (const double speed : {1e-3, 1e-2, 0.1, 0.3}) {
    Bench bench(tool(), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.4));
    bench.state().X_WG = At(0.0, 0.0, rest());
    const Vec3 way = Vec3(0.8, -0.6, 0.0);
    for (int i = 0; i < 2000; ++i) {
      const double moved = 1e-3 * speed * i;
      Pose X = At(0.0, 0.0, rest() - 1e-3);
      X.p += moved * way;
      const StepReport report = bench.Step(X);
      ASSERT_EQ(report.diagnostics.friction_unsolved, 0);
      ExpectContactForcesAddUp(bench, report, 0.6);
      ASSERT_NEAR(report.wrench.force.z(), 1.0, 2e-3);
      if (moved < 0.59e-3) {
        ASSERT_NEAR(Ratio(report, Vec3::UnitZ()), 1e3 * moved, 1e-5) << speed << " " << i;
      } else if (moved > 0.61e-3) {
        ASSERT_NEAR(Ratio(report, Vec3::UnitZ()), 0.4, 4e-5) << speed << " " << i;
        ASSERT_GT(-report.wrench.force.normalized().dot(way), 0.37);
      }
    }
  }
}

TEST_P(FrictionTool, HoldsOnAnInclineUpToTheStaticAngle) {
  for (const double tangent : {0.2, 0.5, 0.59, 0.61, 0.8, 2.0}) {
    const Vec3 normal = Vec3(tangent, 0.0, 1.0).normalized();
    // The tool lies flat on the incline; its load is 1 N, straight down.
    Pose X_WG;
    X_WG.q = RotationBetween(Vec3::UnitZ(), normal);
    X_WG.p = rest() * normal;
    Bench bench(tool(), {Plane(normal)}, Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.4));
    bench.state().X_WG = X_WG;
    StepReport report;
    for (int i = 0; i < 100; ++i) {
      Pose X = bench.state().X_WG;
      X.p.z() -= 1e-3;
      report = bench.Step(X);
      ExpectContactForcesAddUp(bench, report, 0.6);
    }
    const double slid = (bench.state().X_WG.p - X_WG.p).norm();
    if (tangent < 0.6) {
      EXPECT_LT(slid, 1e-8) << tangent;  // the box settles by 4 nm
      EXPECT_NEAR(Ratio(report, normal), tangent, 1e-6);
      EXPECT_NEAR(report.wrench.force.z(), 1.0, 1e-6);
    } else {
      EXPECT_GT(slid, 1e-3) << tangent;
      EXPECT_NEAR(Ratio(report, normal), 0.4, 1e-3) << tangent;
      EXPECT_GT(report.wrench.force.x(), 0.0);  // normal and friction push downhill, along +x
    }
  }
}

TEST_P(FrictionTool, BreaksAwayAtTheStaticLimitAndSticksAgainWhenTheHandRests) {
  Bench bench(tool(), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.8, 0.3));
  bench.state().X_WG = At(0.0, 0.0, rest());
  double x = 0.0;
  const auto pull = [&](int steps, double speed) {
    double most = 0.0;
    for (int i = 0; i < steps; ++i) {
      x += 1e-3 * speed;
      most = std::max(most, Ratio(bench.Step(At(x, 0.0, rest() - 1e-3)), Vec3::UnitZ()));
    }
    return most;
  };
  EXPECT_NEAR(pull(1000, 2e-3), 0.8, 3e-3);  // short of it by up to one step of 2 um
  EXPECT_NEAR(pull(1000, 2e-3), 0.3, 1e-3);
  EXPECT_NEAR(pull(limits::friction::kStillCycles / 2, 0.0), 0.3, 1e-3);  // too short a rest
  EXPECT_NEAR(pull(1000, 2e-3), 0.3, 1e-3);
  pull(2 * limits::friction::kStillCycles, 0.0);
  EXPECT_NEAR(pull(1000, 2e-3), 0.8, 3e-3);
  EXPECT_NEAR(pull(100, 2e-3), 0.3, 1e-3);
  // Lifted off the plane and put back: a new contact sticks.
  for (int i = 0; i < 10; ++i) bench.Step(At(x, 0.0, rest() + 1e-3));
  EXPECT_NEAR(pull(1000, 2e-3), 0.8, 3e-3);
}

TEST_P(FrictionTool, SticksForAMinuteWithoutCreepingThoughTheHandTrembles) {
  Bench bench(tool(), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.4));
  bench.state().X_WG = At(0.0, 0.0, rest());
  Random random(71);
  double farthest = 0.0;
  for (int i = 0; i < 60000; ++i) {
    Pose X = At(0.4e-3, 0.3e-3, rest() - 1e-3);
    X.p += random.InCube(20e-6);
    X.q = RotationExp(random.InCube(1e-3));
    const StepReport report = bench.Step(X);
    farthest = std::max(farthest, (report.X_WG.p - Vec3(0.0, 0.0, rest())).norm());
  }
  RecordProperty("creep_pm", static_cast<int>(1e12 * farthest));
  EXPECT_LT(farthest, 1e-8);  // of which the box settling is 4 nm
}

TEST_P(FrictionTool, GoesOnSlidingThoughTheHandTrembles) {
  // At 5 mm/s a tremble of 20 um often moves the hand back; the tool rests, too briefly to stick.
  Bench bench(tool(), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.8, 0.3));
  bench.state().X_WG = At(0.0, 0.0, rest());
  Random random(72);
  for (int i = 0; i < 5000; ++i) {
    Pose X = At(5e-6 * i, 0.0, rest() - 1e-3);
    X.p += random.InCube(20e-6);
    const double ratio = Ratio(bench.Step(X), Vec3::UnitZ());
    if (i < 300) continue;
    ASSERT_LT(ratio, 0.301) << i;
    ASSERT_GT(ratio, 0.3 - 0.09) << i;  // 2 * 40 um of tremble, in 1 mm of depth
  }
}

TEST(Friction, HoldsATipThatTheHandTremblesAbout) {
  // A stylus of 60 mm, free to turn about its tip, which stays: second-order errors do not add up.
  const std::vector<Ball> stylus{{Vec3(0.0, 0.0, 0.001), 0.001}, {Vec3(0.02, 0.0, 0.06), 0.001}};
  Bench bench(stylus, kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.8, 0.5));
  bench.state().X_WG = At(0.0, 0.0, 0.0);
  Random random(73);
  double farthest = 0.0;
  for (int i = 0; i < 60000; ++i) {
    Pose X = At(0.0, 0.0, -1e-3);
    X.p += random.InCube(20e-6);
    X.q = RotationExp(random.InCube(1e-3));
    const StepReport report = bench.Step(X);
    ASSERT_EQ(report.diagnostics.friction_unsolved, 0);
    farthest = std::max(farthest, std::hypot(report.X_WG.p.x(), report.X_WG.p.y()));
  }
  // The ball at the tip rolls: its lowest point stays, its origin moves by radius times angle.
  EXPECT_LT(farthest, 3e-6);
}

TEST(Friction, HoldsInAGrooveByTheNormalForcesOfItsWalls) {
  // Walls at +-45 degrees carry F / (2 cos 45) each, so friction along the groove is mu F / cos 45.
  // Before sliding, walls may carry more, up to F / (2 (cos 45 - mu sin 45)): how much of the load
  // their friction holds is indeterminate.
  const double cosine = std::sqrt(0.5), sine = cosine;
  for (const bool ball : {true, false}) {
    const std::vector<Ball> rod{{Vec3(0.0, -0.02, 0.0), 0.005}, {Vec3(0.0, 0.02, 0.0), 0.005}};
    Bench bench(ball ? kBallTool : rod,
                {Plane(Vec3(sine, 0.0, cosine)), Plane(Vec3(-sine, 0.0, cosine))},
                Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.4));
    const double rest = 0.005 / cosine;
    bench.state().X_WG = At(0.0, 0.0, rest);
    double most = 0.0;
    int sliding = 0;
    for (int i = 0; i < 2000; ++i) {
      const StepReport report = bench.Step(At(0.0, 2e-6 * i, rest - 1e-3));
      ASSERT_EQ(report.diagnostics.friction_unsolved, 0);
      ExpectContactForcesAddUp(bench, report, 0.6);
      const double ratio = -report.wrench.force.y() / report.wrench.force.z();
      most = std::max(most, ratio);
      ASSERT_NEAR(report.wrench.force.x(), 0.0, 1e-6);
      if (2e-3 * i < 0.59 / cosine) {
        ASSERT_NEAR(report.X_WG.p.y(), 0.0, 1e-10) << i;
      } else if (report.X_WG.p.y() > 1e-6) {
        ASSERT_NEAR(ratio, 0.4 / cosine, 1e-3) << i;
        ++sliding;
      }
    }
    EXPECT_GT(sliding, 500);
    EXPECT_GT(most, 0.6 / cosine - 3e-3);
    EXPECT_LT(most, 0.6 / (cosine - 0.6 * sine));
  }
}

TEST(Friction, ResistsSpinWithTheTorqueOfItsFeet) {
  Bench bench(BoxTool(), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.4));
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  const double radius = 0.02 * std::sqrt(2.0);
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    Pose X = At(0.0, 0.0, 0.01 - 1e-3);
    X.q = RotationExp(Vec3(0.0, 0.0, 5e-5 * i));
    const StepReport report = bench.Step(X);
    ASSERT_EQ(report.diagnostics.friction_unsolved, 0);
    ExpectContactForcesAddUp(bench, report, 0.6);
    const double torque = -report.wrench.torque.z();
    most = std::max(most, torque);
    if (5e-5 * i < 0.59 * radius) {
      ASSERT_NEAR(torque, 5e-5 * i, 1e-8) << i;
    } else if (5e-5 * i > 0.61 * radius) {
      ASSERT_NEAR(torque, 0.4 * radius, 4e-4 * radius) << i;
    }
  }
  EXPECT_NEAR(most, 0.6 * radius, 6e-5);
}

TEST(Friction, TipsABoxOverItsEdgeRatherThanSlideIt) {
  // Feet 2 mm apart, 10 mm below the centroid: it tips once 0.6 F * 10 mm exceeds F * 1 mm plus the
  // torque of the coupling.  A foot that has left the plane has no friction.
  Bench bench(BoxTool(0.001), kPlane, Rubbing(FrictionModel::kCoulomb), Rough(0.6, 0.6));
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  StepReport report;
  for (int i = 0; i < 3000; ++i) {
    report = bench.Step(At(1e-6 * i, 0.0, 0.01 - 1e-3));
    ASSERT_EQ(report.diagnostics.friction_unsolved, 0) << i;
    ExpectContactForcesAddUp(bench, report, 0.6);
  }
  EXPECT_NEAR(Ratio(report, Vec3::UnitZ()), 0.6, 1e-3);
  EXPECT_GT(report.wrench.torque.norm(), 1e-3);
  for (int i = 0; i < report.contacts; ++i) {
    const Vec3 foot =
        bench.state().X_WG.Inverse() * report.active[static_cast<std::size_t>(i)].contact_W;
    EXPECT_GT(foot.x(), 0.0);
  }
}

TEST(Friction, KeepsEveryForceInItsConeAndTheToolOutsideInRandomScenes) {
  const int scenes = kOptimised ? 10 : 2;
  int contacts = 0, steps = 0, unsolved = 0, yielded = 0;
  double deepest = 0.0;
  for (const double mu : {0.1, 0.3, 0.6, 1.0}) {
    for (int scene = 0; scene < scenes; ++scene) {
      Random random(static_cast<std::uint64_t>(1000 * scene) + 7);
      Bench bench(RandomBalls(random, scene % 4 == 0 ? 1 : 60, 0.02, 0.004),
                  RandomBalls(random, 200, 0.05, 0.005), Rubbing(FrictionModel::kCoulomb),
                  Rough(1.5 * mu, mu));
      bench.state().X_WG = At(0.0, 0.0, 0.15);
      Wander(bench, random, 2000, [&](const StepReport& report) {
        ASSERT_TRUE(report.wrench.force.allFinite() && report.wrench.torque.allFinite());
        ExpectContactForcesAddUp(bench, report, 1.5 * mu);
        deepest = std::max(deepest, bench.Penetration());
        ++steps;
        contacts += report.contacts > 0;
        unsolved += report.diagnostics.friction_unsolved > 0;
        yielded += report.diagnostics.friction_yielded > 0;
      });
    }
  }
  // Balls wedged among balls: friction lacks a solution here more often than in a real scene.
  EXPECT_GT(contacts, kOptimised ? 50000 : steps / 2);
  EXPECT_LT(deepest, 2e-6);
  EXPECT_LT(yielded, contacts / 40);
  EXPECT_LT(unsolved, contacts / 100);
}

/// The lever of the point at which a row touches when it holds.
Vec3 LeverWhereItTouches(const ContactRows& rows, int row) {
  return rows.lever(row) - rows.gap(row) * rows.normal(row);
}

/// How far contacts are from Coulomb's law at the x that their forces balance.
/// @param turns  whether it is no ball.   @param mu_s, mu_d  of every contact.   @return the
/// greatest error of a force [m]
double ErrorOfLaw(const ContactRows& rows, const Optimum& found, const Vec6& t, double rho,
                  bool turns, double mu_s, double mu_d) {
  std::vector<Vec3> force(static_cast<std::size_t>(rows.count()), Vec3::Zero());
  Vec6 x = t;
  for (int k = 0; k < found.qp.active; ++k) {
    const int i = found.qp.row[k];
    Vec3& f = force[static_cast<std::size_t>(i)];
    f = found.qp.multiplier[k] * rows.normal(i) + found.friction[static_cast<std::size_t>(k)];
    x.head<3>() += f;
    x.tail<3>() += LeverWhereItTouches(rows, i).cross(f) / rho;
  }
  if (!turns) x.tail<3>().setZero();
  double error = 0.0;
  for (int i = 0; i < rows.count(); ++i) {
    const Vec3 n = rows.normal(i), f = force[static_cast<std::size_t>(i)];
    const Vec3 moved = x.head<3>() + Vec3(x.tail<3>() / rho).cross(LeverWhereItTouches(rows, i));
    const double lambda = n.dot(f), left = rows.gap(i) + n.dot(moved);
    const Vec3 slip = moved - n.dot(moved) * n, friction = f - lambda * n;
    const double limit = (slip.norm() > 1e-6 * t.norm() ? mu_d : mu_s) * lambda;
    Vec3 law = friction - slip;  // friction is its projection onto the disk
    if (law.norm() > limit) law *= limit / law.norm();
    error = std::max({error, std::fabs(std::min(lambda, left)), (law - friction).norm()});
  }
  return error;
}

TEST(Friction, SatisfiesCoulombsLawInRandomProblems) {
  int solved = 0, not_solved = 0;
  for (const bool turns : {false, true}) {
    for (int tenths = 0; tenths <= 12; ++tenths) {
      const double mu_d = 0.1 * tenths, mu_s = tenths % 2 == 0 ? 1.5 * mu_d : mu_d;
      Random setup(11);
      Bench bench(turns ? RandomBalls(setup, 7, 0.02, 0.004) : kBallTool, kPlane,
                  Rubbing(FrictionModel::kCoulomb), Rough(mu_s, mu_d));
      const HapticModel& model = bench.model();
      const double rho = model.rotation_length();
      ContactRows& rows = bench.workspace().buffers().rows;
      for (int problem = 0; problem < (kOptimised ? 400 : 40); ++problem) {
        Random random(static_cast<std::uint64_t>(problem * 16 + tenths));
        const Mat3 R_WG = random.Rotation().toRotationMatrix();
        const Vec3 up = random.InCube(1.0).normalized();
        const double rough = 0.5 * (problem / 7 % 4);  // from a plane to normals on all sides
        rows.Clear();
        for (int i = 0; i < 1 + problem % 7; ++i) {
          const Vec3 n = (up + rough * random.InCube(1.0)).normalized();
          const auto tool = static_cast<std::size_t>(i) % model.tool().leaves.size();
          const LeafSphere& leaf = model.tool().leaves[tool];
          rows.AddRow(n, R_WG * Vec3(leaf.x, leaf.y, leaf.z) - leaf.radius * n,
                      random.Uniform(0.0, problem % 3 * 5e-5),
                      {ContactId::kLeaves, static_cast<std::int32_t>(tool), 0, i});
        }
        rows.Finish();
        StepState state;
        if (problem % 2 != 0) state.friction.still = 0;
        Target target{random.Uniform(-2e-3, -2e-4) * up + random.InCube(2e-3),
                      random.InCube(turns ? 0.05 : 0.0)};
        for (int step = 0; step < 6; ++step) {  // from the second on, with forces to start from
          Vec6 t;
          t << target.v, rho * target.phi;
          Optimum optimum;
          optimum.qp = ActiveKernels().solve(t.data(), rows.view(), nullptr, 0);
          if (optimum.qp.status != QpStatus::kSolved || optimum.qp.active == 0) break;
          StepReport counts;
          StepContext context(model, state, bench.workspace().buffers(), counts);
          context.tools.R_WG = R_WG;
          context.sub_step.target = target;
          context.sub_step.rigid = rows.view();
          context.friction = state.friction;
          AddFriction(context, optimum);
          state.friction = context.friction;
          if (optimum.friction_yielded || optimum.friction_unsolved) {
            ++not_solved;
          } else {
            ++solved;
            ASSERT_LT(ErrorOfLaw(rows, optimum, t, rho, turns, mu_s, mu_d), 1e-6 * t.norm())
                << turns << " " << tenths << " " << problem << " " << step;
          }
          target.v += random.InCube(5e-5);
          if (turns) target.phi += random.InCube(1e-3);
        }
      }
    }
  }
  EXPECT_GT(solved, kOptimised ? 40000 : 4000);
  EXPECT_LT(not_solved, solved / 30);  // wedged among normals on all sides
}

/// A corner of a tool near a plane.
struct Corner {
  Vec3 n, at;  ///< unit normal of the plane; from the reference point to where it touches [m]
  double gap;  ///< [m]
  double force = 0.0;  ///< with which the last sub-step pressed it, over k_t [m]
};

/// Finds friction where the corners are all that touches, and expects the law: each force in its
/// cone, against the slip of its point, none where there is a gap, and all in balance at the step.
/// @param t  the hand's way [m] and turn [rad]: the target of one sub-step, and of the next ones
void ExpectTheLaw(const std::vector<Corner>& corners, std::vector<Target> targets, bool has_slid,
                  const std::string& which) {
  constexpr double kRadius = 1e-4, kStatic = 0.5, kDynamic = 0.3;
  std::vector<Ball> tool;
  for (const Corner& corner : corners) {
    const Vec3 centre = corner.at + (corner.gap + kRadius) * corner.n;
    tool.push_back({centre, kRadius});
    tool.push_back({-centre, kRadius});  // so that the reference point is the origin
  }
  Bench bench(tool, kPlane, Rubbing(FrictionModel::kCoulomb), Rough(kStatic, kDynamic));
  const HapticModel& model = bench.model();
  ContactRows& rows = bench.workspace().buffers().rows;
  StepState state;
  if (has_slid) state.friction.still = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto is_at = [&](const LeafSphere& leaf) {
      return (Vec3(leaf.x, leaf.y, leaf.z) - tool[2 * i].center).norm() < 1e-12;
    };
    const auto leaf = std::ranges::find_if(model.tool().leaves, is_at);
    ASSERT_NE(leaf, model.tool().leaves.end()) << which;
    const ContactId id{ContactId::kLeaves,
                       static_cast<std::int32_t>(leaf - model.tool().leaves.begin()), 0,
                       static_cast<std::int32_t>(i)};
    rows.AddRow(corners[i].n, corners[i].at + corners[i].gap * corners[i].n, corners[i].gap, id);
    if (corners[i].force == 0.0) continue;
    const auto k = static_cast<std::size_t>(state.friction.contacts++);
    state.friction.id[k] = id;
    state.friction.normal_force[k] = corners[i].force;
    state.friction.force[k].setZero();
  }
  rows.Finish();
  const double rho = model.rotation_length();
  for (const Target& target : targets) {
    Vec6 t;
    t << target.v, rho * target.phi;
    Optimum optimum;
    optimum.qp = ActiveKernels().solve(t.data(), rows.view(), nullptr, 0);
    ASSERT_EQ(optimum.qp.status, QpStatus::kSolved) << which;
    if (optimum.qp.active == 0) continue;
    StepReport counts;
    StepContext context(model, state, bench.workspace().buffers(), counts);
    context.tools.R_WG.setIdentity();
    context.sub_step.target = target;
    context.sub_step.rigid = rows.view();
    context.friction = state.friction;
    AddFriction(context, optimum);
    state.friction = context.friction;
    ASSERT_FALSE(optimum.friction_unsolved) << which;
    // A newton presses a contact 1 nm into its row.
    ASSERT_LT(ErrorOfLaw(rows, optimum, t, rho, true, kStatic, kDynamic), 2e-6 * t.norm()) << which;
    Vec6 balanced = t, x = Vec6::Map(optimum.qp.x);
    for (int k = 0; k < optimum.qp.active; ++k) {
      const int row = optimum.qp.row[k];
      const Vec3 friction = optimum.friction[static_cast<std::size_t>(k)];
      const Vec3 f = optimum.qp.multiplier[k] * rows.normal(row) + friction;
      balanced.head<3>() += f;
      balanced.tail<3>() += LeverWhereItTouches(rows, row).cross(f) / rho;
      ASSERT_GE(optimum.qp.multiplier[k], 0.0) << which;
      ASSERT_LE(friction.norm(), kStatic * optimum.qp.multiplier[k] + 1e-8 * t.norm()) << which;
    }
    // Up to what Creep corrects: the second order of the turn.
    const double turned = x.tail<3>().norm() / rho;
    ASSERT_LT((balanced - x).norm(), 2e-6 * t.norm() + 0.1 * turned * turned) << which;
  }
}

// Sub-steps in which a corner or an edge of a foot has come down on a plate and the others follow.
// They were recorded where friction was not found.
TEST(Friction, IsFoundWhereAFootComesDownOnAPlate) {
  const Vec3 up = Vec3::UnitY();
  ExpectTheLaw(
      {{up, {-5.05515462e-3, -4.27712712e-3, -2.91859488e-3}, 4.12890221e-12, 7.6655e-6},
       {up, {5.80028765e-3, -4.27724018e-3, -2.91859489e-3}, -3.00003089e-7},
       {up, {-1.627657e-7, -4.27723073e-3, 5.83690785e-3}, -2.81089177e-7}},
      {{{-1.62849723e-7, -1.80319023e-5, -9.40213314e-8}, {-2.19693675e-5, 0.0, 3.80520607e-5}}},
      false, "triangle");
  const Vec3 a = Vec3(2.95086322e-6, 1.0, 0.0).normalized();
  ExpectTheLaw({{a, {-8.93752476e-4, -2.68830191e-3, -2.73444923e-4}, 1.17936285e-14, 2.75735e-6},
                {a, {-8.93752476e-4, -2.68830191e-3, 1.32655508e-3}, 1.17936291e-14, 5.68377e-7},
                {up, {6.89630401e-3, -2.68730191e-3, 4.42035983e-3}, -2.29873794e-8},
                {up, {6.89630401e-3, -2.68730191e-3, -4.42035983e-3}, -2.29873794e-8}},
               {{{-7.96281759e-9, -1.17180198e-5, 0.0}, {0.0, 0.0, 2.95086322e-6}}}, false,
               "hexagon");
  ExpectTheLaw(
      {{up, {2.33556579e-3, -5.32771422e-3, -4.82945657e-3}, 5.75071167e-12, 8.90729e-6},
       {up, {3.58693477e-3, -5.32778699e-3, 4.36812576e-3}, -2.86623171e-7},
       {up, {-5.74929192e-3, -5.32780867e-3, 6.91274189e-4}, -3e-7},
       {up, {2.04940734e-3, -5.32771422e-3, -4.79503946e-3}, -7.22229369e-9}},
      {{{1.07791791e-7, -1.90605915e-5, -2.22890647e-7}, {-4.18275693e-5, 0.0, -2.02281641e-5}}},
      false, "pins");
}

// Where both ends of a line begin to slip, Newton's method went round three places for good.
TEST(Friction, IsFoundWhereAnEdgeBeginsToSlip) {
  ExpectTheLaw({{Vec3(-0.166212209, -0.298415268, 0.939852025).normalized(),
                 {5.85981371e-4, 4.11136952e-3, -3.2744812e-3},
                 -5.18748987e-10},
                {Vec3(-0.166211732, -0.298415273, 0.939852108).normalized(),
                 {7.0663417e-4, 1.30041695e-3, -4.14565791e-3},
                 1.18148821e-9}},
               {{{-5.13709016e-5, 4.06580057e-4, -7.59558415e-4},
                 {-5.69868058e-5, 6.89084829e-4, 3.75354724e-4}}},
               true, "cylinder");
}

TEST(Friction, ObeysItsLawOnRandomFacesThatOnePlaneCarries) {
  for (std::uint64_t seed = 0; seed < (kOptimised ? 600u : 60u); ++seed) {
    Random random(seed);
    const Vec3 up = random.InCube(1.0).normalized(), east = up.unitOrthogonal();
    const Vec3 north = up.cross(east);
    const double size = random.Uniform(2e-3, 2e-2), height = random.Uniform(2e-3, 2e-2);
    // Normals and gaps of one plane differ by roundings; those of a foot that tilts by more.
    const double bent = std::pow(10.0, random.Uniform(-16.0, -5.0));
    const double uneven = std::pow(10.0, random.Uniform(-16.0, -6.5));
    std::vector<Corner> corners;
    const int count = 3 + random.Below(5);
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * M_PI * i / count + random.Uniform(-0.3, 0.3);
      const Vec3 beside = size * (std::cos(angle) * east + std::sin(angle) * north);
      corners.push_back({(up + bent * random.InCube(1.0)).normalized(), beside - height * up,
                         uneven * random.Uniform(-1.0, 1.0)});
    }
    Target target{std::pow(10.0, random.Uniform(-5.0, -2.5)) * (random.InCube(0.5) - up),
                  seed % 3 == 0 ? Vec3(random.InCube(5e-3)) : Vec3::Zero()};
    std::vector<Target> targets;
    for (int step = 0; step < 6; ++step) {
      targets.push_back(target);
      target.v += 0.02 * target.v.norm() * random.InCube(1.0);
    }
    ExpectTheLaw(corners, targets, seed % 2 == 0, "seed " + std::to_string(seed));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// The weakest torsional spring that a model accepts, beside translational springs up to stiff ones.
TEST(Friction, GivesNumbersWithAnySpringThatAModelTakes) {
  for (const double stiffness : {1.0, 1000.0, 4e5, 1e7}) {
    StepParameters parameters = Rubbing(FrictionModel::kCoulomb);
    parameters.stiffness = stiffness;
    Random random(77);
    const std::vector<Ball> tool = RandomBalls(random, 60, 0.02, 0.004),
                            object = RandomBalls(random, 200, 0.05, 0.005);
    const double lever = Bench(tool, object).model().tool().max_lever;
    parameters.torsional_stiffness = 1e-6 * stiffness * lever * lever * (1.0 + 1e-12);
    Bench bench(tool, object, parameters, Rough(0.8, 0.3));
    bench.state().X_WG = At(0.0, 0.0, 0.15);
    Wander(bench, random, 1000, [&](const StepReport& report) {
      ASSERT_TRUE(report.wrench.force.allFinite() && report.wrench.torque.allFinite());
      ASSERT_EQ(report.faults & kFaultUnsolved, 0u);
    });
    EXPECT_LT(bench.Penetration(), 1e-6);
    parameters.torsional_stiffness *= 0.999;
    try {
      Bench refused(tool, object, parameters);
      FAIL() << "a spring that friction's arithmetic cannot hold";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("torsional_stiffness"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("give at least"), std::string::npos);
    }
  }
}

TEST(Friction, OffGivesTheBitsOfASmoothObject) {
  for (const bool box : {false, true}) {
    Random random(75);
    const std::vector<Ball> object = RandomBalls(random, 200, 0.05, 0.005);
    const std::vector<Ball> tool = box ? BoxTool() : kBallTool;
    Bench smooth(tool, object), rough(tool, object, {}, Rough(0.8, 0.3));
    Bench frictionless(tool, object, Rubbing(FrictionModel::kCoulomb), Rough(0.0, 0.0));
    for (Bench* bench : {&smooth, &rough, &frictionless}) bench->state().X_WG = At(0.0, 0.0, 0.1);
    for (int i = 0; i < 2000; ++i) {
      Pose X = At(1e-5 * i, 0.0, 0.1 - 5e-5 * i);
      X.q = RotationExp(Vec3(1e-4 * i, 0.0, 0.0));
      const StepReport a = smooth.Step(X), b = rough.Step(X), c = frictionless.Step(X);
      ASSERT_EQ(a.wrench.force, b.wrench.force);
      ASSERT_EQ(a.wrench.torque, b.wrench.torque);
      ASSERT_EQ(a.X_WG.p, b.X_WG.p);
      // With mu = 0 another branch of the code reaches the same pose.
      ASSERT_LT((a.X_WG.p - c.X_WG.p).norm(), 1e-8) << i;
    }
  }
}

TEST(Friction, AllocatesNothing) {
  ExpectNoAllocation(FrictionModel::kCoulomb);
}

}  // namespace
}  // namespace palpate
