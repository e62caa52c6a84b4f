// Hands that the contact was not tuned for, over small meshes of all kinds: checks what the
// invariant promises, with an oracle that shares no code with it.
#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/physics/contact/contact_scenes.h"
#include "tests/support/contact_figures.h"
#include "tests/support/hand_path.h"
#include "tests/support/hand_trial.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/random.h"
#include "tests/support/sharp_bodies.h"

namespace palpate {
namespace {

using test::BallBody;
using test::ContactLimits;
using test::Crowded;
using test::Flat;
using test::kCrowded;
using test::MakeBlock;
using test::MakeCrumpled;
using test::MakeFinnedBox;
using test::MakeHand;
using test::MakeL;
using test::MakeMeshBody;
using test::MakeSheet;
using test::MakeTerraced;
using test::MeshScene;
using test::Random;
using test::Scaled;
using test::Waves;

struct Case {
  const char* name;
  Scene (*make)();
  double size;  ///< extent of the region hands move in [m]
};

const Case kCases[] = {
    {"a box on a box",
     [] { return MeshScene(MakeBox(Vec3(0.03, 0.02, 0.04)), MakeBox(Vec3(0.06, 0.05, 0.04))); },
     0.04},
    {"a faceted ball on a flat grid",
     [] { return MeshScene(MakeSphere(0.015, 320), MakeBlock(16, 0.04, 0.02, Flat)); }, 0.04},
    {"waves on waves",
     [] {
       return MeshScene(MakeBlock(12, 0.015, 0.01, Waves(0.001, 0.015)),
                        MakeBlock(24, 0.04, 0.02, Waves(0.002, 0.04)));
     },
     0.04},
    {"a box on an open sheet",
     [] { return MeshScene(MakeBox(Vec3::Constant(0.02)), MakeSheet(8, 0.04, Flat)); }, 0.04},
    {"an open sheet on an open sheet",
     [] {
       return MeshScene(MakeSheet(4, 0.02, Waves(0.002, 0.02)),
                        MakeSheet(8, 0.04, Waves(0.003, 0.04)));
     },
     0.04},
    {"a fin on a fin",
     [] {
       return MeshScene(MakeFinnedBox(Vec3::Constant(0.02), 0.01),
                        MakeFinnedBox(Vec3(0.05, 0.04, 0.02), 0.02));
     },
     0.04},
    {"an L in an L", [] { return MeshScene(MakeL(0.03), MakeL(0.06)); }, 0.04},
    {"crumple on crumple",
     [] { return MeshScene(MakeCrumpled(6, 0.02, 0.004, 9), MakeCrumpled(12, 0.04, 0.006, 7)); },
     0.04},
    {"needles on needles",
     [] {
       return MeshScene(MakeBlock(kCrowded, 0.015, 0.01, Waves(0.001, 0.015), Crowded),
                        MakeBlock(kCrowded, 0.04, 0.02, Waves(0.003, 0.04), Crowded));
     },
     0.04},
    {"bars crossed",
     [] { return MeshScene(MakeBox(Vec3(0.1, 0.01, 0.01)), MakeBox(Vec3(0.01, 0.1, 0.01))); },
     0.04},
    {"a pipe on a pipe",
     [] {
       return MeshScene(MakeBentPipe(0.006, 0.002, 0.04, 0.02),
                        MakeBentPipe(0.01, 0.002, 0.08, 0.04));
     },
     0.05},
    {"a millimetre",
     [] {
       return MeshScene(Scaled(MakeBox(Vec3(0.03, 0.02, 0.04)), 0.02),
                        Scaled(MakeBlock(8, 0.04, 0.02, Waves(0.002, 0.04)), 0.02));
     },
     0.0008},
};

TEST(MeshContactHands, KeepOutArriveAndSettleWithoutJumpsThatNothingExplains) {
  for (const Case& c : kCases) {
    test::HandTrial candidate;
    candidate.last_seed = 2;
    candidate.steps = 800;
    candidate.checks.quarter_steps = false;
    candidate.limits = {.meeting_fraction = 0.0,
                        .depth = 0.0,
                        .arrived_fraction = 0.99,
                        .unexplained = 0,
                        .settled_50ms = 1.0};
    EXPECT_EQ(TryHands(c.make(), candidate), "") << c.name;
  }
}

/// Results over hands of 400 steps, for the steps in which the tool arrived.
struct Arrived {
  std::vector<double> error;  ///< change of force after further cycles, sorted [N]
  double share;               ///< fraction of the steps
};
Arrived TryArriving(const Scene& scene, double speed, std::uint64_t last_seed) {
  Arrived all;
  std::size_t steps = 0, arrived = 0;
  for (std::uint64_t seed = 1; seed <= last_seed; ++seed) {
    const test::ContactFigures figures =
        test::MeasureContact(scene, MakeHand(scene, {.seed = seed, .speed = speed, .steps = 400}),
                             {.oracle_every = 0, .converge_every = 4});
    all.error.insert(all.error.end(), figures.arrived_error.begin(), figures.arrived_error.end());
    steps += figures.steps;
    arrived += figures.arrived;
  }
  std::sort(all.error.begin(), all.error.end());
  all.share = static_cast<double>(arrived) / static_cast<double>(steps);
  return all;
}
double Quantile(const std::vector<double>& sorted, double q) {
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size()))];
}

// The tool has arrived when contacts hold it, not planes that were made for a pose along the way:
// further cycles with the same hand would not change the force.  The exceptions are tools about to
// slip, and edges that lie on a face beyond its rim.
TEST(MeshContactHands, ArriveWhereFurtherCyclesWouldNotMoveThem) {
  std::vector<double> error;
  for (const Case& c : kCases) {
    const Arrived tried = TryArriving(c.make(), 0.1, 3);
    error.insert(error.end(), tried.error.begin(), tried.error.end());
  }
  ASSERT_GT(error.size(), 3000u);
  std::sort(error.begin(), error.end());
  EXPECT_LT(Quantile(error, 0.99), 0.005) << "N, of a few";
  EXPECT_LT(Quantile(error, 0.998), 0.05);
}

// A pair outside its cones is kept apart by the plane of a touching neighbour: its own plane would
// hold the tool where nothing touches.
TEST(MeshContactHands, AreNotHeldByPairsWhoseNeighbourTouches) {
  for (const char* name : {"waves on waves", "crumple on crumple"}) {
    const auto c = std::find_if(std::begin(kCases), std::end(kCases),
                                [name](const Case& of) { return std::string(name) == of.name; });
    const Arrived tried = TryArriving(c->make(), 0.3, 4);
    EXPECT_LT(tried.error.back(), 0.05) << "N, " << name;
  }
}

// The same with triangles that are small relative to the motion of a cycle, so contacts change all
// the time.  With one ball's mesh on another, a candidate that is free without the non-touching
// planes may itself be held by such planes.
TEST(MeshContactHands, ArriveOnFineMeshes) {
  struct Fine {
    const char* name;
    Scene scene;
    double most;  ///< [N]
  };
  const double slips = std::numeric_limits<double>::infinity();
  const Fine all[] = {
      {"crumple on crumple",
       MeshScene(MakeCrumpled(40, 0.02, 0.0005, 9), MakeCrumpled(60, 0.04, 0.0005, 7)), slips},
      {"crumple on waves",
       MeshScene(MakeCrumpled(40, 0.02, 0.001, 9), MakeBlock(60, 0.04, 0.02, Waves(0.004, 0.04))),
       slips},
      {"waves on waves",
       MeshScene(MakeBlock(60, 0.02, 0.01, Waves(0.003, 0.01)),
                 MakeBlock(80, 0.04, 0.02, Waves(0.003, 0.015))),
       slips},
      {"a ball on a ball", MeshScene(MakeSphere(0.02, 5120), MakeSphere(0.03, 20480)), 0.04}};
  for (const Fine& fine : all) {
    const Arrived tried = TryArriving(fine.scene, 0.3, 4);
    EXPECT_GT(tried.share, 0.99) << fine.name;
    EXPECT_LT(Quantile(tried.error, 0.99), 0.01) << "N, " << fine.name;
    EXPECT_LT(tried.error.back(), fine.most) << "N, " << fine.name;
  }
}

// On crumples this fine several features touch within the separation, and which of them belong to a
// pair is ambiguous: a tool at rest must not decide anew in each step.
TEST(MeshContactHands, ComeToRestOnCrumplesThatHardlyStandOut) {
  const Case cases[] = {{"on another",
                         [] {
                           return MeshScene(MakeCrumpled(40, 0.02, 0.0005, 9),
                                            MakeCrumpled(60, 0.04, 0.0005, 7));
                         },
                         0.04},
                        {"in waves",
                         [] {
                           return MeshScene(MakeCrumpled(40, 0.02, 0.001, 9),
                                            MakeBlock(60, 0.04, 0.02, Waves(0.004, 0.04)));
                         },
                         0.04}};
  for (const Case& c : cases) {
    test::HandTrial candidate;
    candidate.last_seed = 4;
    candidate.steps = 800;
    candidate.checks = {.oracle_every = 0, .converge_every = 0, .settle_every = 20};
    candidate.limits = {.settled_50ms = 1.0};
    EXPECT_EQ(TryHands(c.make(), candidate), "") << c.name;
  }
}

// Hands so fast that the tool falls behind, and that then stand still.  Where rows of non-touching
// pairs hold the tool and the way past them is not free, those rows are its contacts: it has
// arrived and feels them.  It must not lag for ever, least of all without a force.
TEST(MeshContactHands, ArriveOnceTheHandStandsStill) {
  const Scene waves = MeshScene(MakeBlock(60, 0.02, 0.01, Waves(0.003, 0.01)),
                                MakeBlock(80, 0.04, 0.02, Waves(0.003, 0.015)));
  const Scene fine =
      MeshScene(MakeCrumpled(40, 0.02, 0.001, 9), MakeBlock(60, 0.04, 0.02, Waves(0.004, 0.04)));
  const Scene crumple =
      MeshScene(MakeCrumpled(6, 0.02, 0.004, 9), MakeCrumpled(12, 0.04, 0.006, 7));
  // Each candidate brings new rows, in an endless cycle.
  const auto terraces = [](std::uint64_t seed) {
    return MeshScene(MakeTerraced(0.04, 5120, seed), MakeTerraced(0.04, 5120, seed + 100));
  };
  const Scene some = terraces(3), others = terraces(5);
  const struct {
    const Scene& scene;
    double speed;
    std::uint64_t seed;
    std::size_t steps;  ///< until just after such a pose
    int path = 800;     ///< steps of the whole path
  } hands[] = {{waves, 0.5, 4, 400},         {waves, 0.5, 9, 300},          {fine, 0.5, 1, 400},
               {fine, 0.5, 7, 300},          {fine, 0.5, 10, 290},          {crumple, 0.3, 4, 610},
               {some, 0.08, 19, 1800, 2000}, {others, 0.08, 10, 1150, 2000}};
  for (const auto& hand : hands) {
    std::vector<Pose> X_WH =
        MakeHand(hand.scene, {.seed = hand.seed, .speed = hand.speed, .steps = hand.path});
    X_WH.resize(hand.steps);
    const test::ContactFigures figures = test::MeasureContact(
        hand.scene, X_WH, {.oracle_every = 0, .converge_every = 0, .hold_far = true});
    EXPECT_EQ(BrokenLimits(figures, {.never_arrived = 0}), "") << "seed " << hand.seed;
  }
}

// A ball takes its normals from the smooth surface and its positions from the facets.  Coarse
// facets lift it by up to a tenth of its motion; beside a smooth triangle may lie a crease.
TEST(MeshContactHands, ArriveAsABallOnTerracesAndFacets) {
  const TriangleMesh bodies[] = {MakeTerraced(0.04, 5120, 3), MakeTerraced(0.04, 5120, 105),
                                 MakeBentPipe(0.012, 0.006, 0.12, 4.0),
                                 MakeBlock(60, 0.04, 0.02, Waves(0.004, 0.02))};
  std::size_t moves_on = 0, judged = 0;
  for (const TriangleMesh& body : bodies) {
    Scene scene;
    scene.features.contact = ContactModel::kSurface;
    scene.tools.push_back(BallBody(0.0045));
    scene.objects.push_back(MakeMeshBody("body", body));
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const std::vector<Pose> X_WH =
          MakeHand(scene, {.seed = seed, .speed = 0.08, .steps = 2000, .press_mm = 12.0});
      const test::ContactFigures figures = test::MeasureContact(
          scene, X_WH, {.oracle_every = 20, .converge_every = 5, .hold_far = true});
      EXPECT_EQ(BrokenLimits(figures, {.arrived_fraction = 0.99, .never_arrived = 0}), "")
          << &body - bodies << ", seed " << seed;
      for (const double error : figures.arrived_error) moves_on += error > 0.02 ? 1 : 0;
      judged += figures.arrived_error.size();
    }
  }
  // One that has arrived stays, but where it begins to roll off an edge and hardly moves at first.
  EXPECT_LE(moves_on, judged / 250);
}

TEST(MeshContactHands, FeelWhatHoldsThemWhileTheyLag) {
  const Scene terraces = MeshScene(MakeTerraced(0.04, 5120, 3), MakeTerraced(0.04, 5120, 103));
  std::vector<double> errors;  // force while lagging, minus the force once the tool has arrived
  std::size_t notches = 0;
  for (std::uint64_t seed = 15; seed < 25; ++seed) {
    const std::vector<Pose> X_WH = MakeHand(terraces, {.seed = seed, .speed = 0.08, .steps = 2000});
    const test::ContactFigures figures = test::MeasureContact(
        terraces, X_WH, {.oracle_every = 0, .converge_every = 0, .hold_far = true});
    errors.insert(errors.end(), figures.held.force_error.begin(), figures.held.force_error.end());
    notches += figures.force.notches.size();
  }
  std::ranges::sort(errors);
  ASSERT_GT(errors.size(), 5u) << "late cycles to look at";
  EXPECT_LT(errors[errors.size() / 2], 0.3) << "N, at the median of " << errors.size();
  EXPECT_LE(notches, 1u);
}

/// A hand that no arm could perform: it jumps, dives, spins, trembles and rests, mostly inside.
std::vector<Pose> WildHand(double size, std::uint64_t seed, std::size_t steps) {
  Random random(seed);
  Pose at{Vec3(0.0, 0.0, 2.0 * size), Quat::Identity()};
  std::vector<Pose> X_WH{at};
  while (X_WH.size() < steps) {
    Pose to = at;
    int moving = 1;
    switch (random.Below(5)) {
      case 0:
        to = {size * random.InCube(1.0), random.Rotation()};
        break;
      case 1:
        to = {size * random.InCube(1.0), random.Rotation()};
        moving = 1 + random.Below(100);
        break;
      case 2:
        to = {at.p + 0.05 * size * random.InCube(1.0),
              RotationExp(0.3 * random.InCube(1.0)) * at.q};
        moving = 1 + random.Below(50);
        break;
      case 3:
        to = {at.p + 1e-3 * size * random.InCube(1.0),
              RotationExp(0.02 * random.InCube(1.0)) * at.q};
        moving = 1 + random.Below(20);
        break;
      default:
        to.q = RotationExp(1.5 * random.InCube(1.0)) * at.q;
        moving = 1 + random.Below(100);
    }
    const Vec3 turn = RotationLog(to.q * at.q.conjugate());
    for (int i = 1; i <= moving; ++i) {
      const double s = static_cast<double>(i) / moving;
      X_WH.push_back({(1.0 - s) * at.p + s * to.p, (RotationExp(s * turn) * at.q).normalized()});
    }
    at = X_WH.back();
    X_WH.insert(X_WH.end(), static_cast<std::size_t>(random.Below(30)), at);
  }
  return X_WH;
}

TEST(MeshContactHands, NeverBringMeshesIntoEachOtherHoweverWild) {
  for (const Case& c : kCases) {
    const Scene scene = c.make();
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const test::ContactFigures figures = test::MeasureContact(
          scene, WildHand(c.size, seed, 1000), {.oracle_every = 1, .converge_every = 0});
      ContactLimits limits{.meeting_fraction = 0.0, .depth = 0.0};
      EXPECT_EQ(BrokenLimits(figures, limits), "") << c.name << ", seed " << seed;
    }
  }
}

// A tool that lags rests at a free pose, whatever the rows made for candidates elsewhere say: the
// force may not exceed what the spring gives there.
TEST(MeshContactHands, GetNoMoreForceThanTheSpringHas) {
  for (const Case& c : kCases) {
    Scene scene = c.make();
    scene.tuning.sub_steps = 8;  // so that some lag
    const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
    const StepParameters& spring = model.parameters();
    const double rho2 = spring.torsional_stiffness / spring.stiffness;
    StepWorkspace workspace(model);
    StepState state(model);
    int far = 0;
    for (const std::uint64_t seed : {3, 4}) {
      const std::vector<Pose> hand = WildHand(c.size, seed, 1000);
      if (seed == 3) state.X_WG = state.X_WH = hand.front();
      for (const Pose& X_WH : hand) {
        const StepReport report = HapticStep(model, X_WH, state, workspace);
        far += (report.faults & kFaultTargetFar) != 0;
        const Vec3 away = X_WH * model.reference() - report.X_WG * model.reference();
        const double turned = RotationLog(X_WH.q * report.X_WG.q.conjugate()).norm();
        // Lengths in the metric of the spring: rho = sqrt(k_r / k_t).
        const double pull =
            std::hypot(report.wrench.force.norm() / spring.stiffness,
                       report.wrench.torque.norm() / (std::sqrt(rho2) * spring.stiffness));
        const double stretch = std::hypot(away.norm(), std::sqrt(rho2) * turned);
        ASSERT_LE(pull, stretch + 1e-6) << c.name << ", seed " << seed;
      }
    }
    EXPECT_GT(far, 40) << c.name;
  }
}

// At ten metres: bounds and tolerances are absolute lengths and do not scale with the size.
TEST(MeshContactHands, KeepOutAtTenMetres) {
  Scene scene = MeshScene(Scaled(MakeBox(Vec3(0.03, 0.02, 0.04)), 100.0),
                          Scaled(MakeBlock(8, 0.04, 0.02, Waves(0.002, 0.04)), 100.0));
  scene.coupling.torsional_stiffness = 1e4;  // scales with the square of the size
  Random random(71);
  std::vector<Pose> X_WH{{Vec3(0.3, 0.2, 2.3), Quat::Identity()}};
  const auto go = [&](const Vec3& by, const Vec3& turn, int steps) {
    const Pose from = X_WH.back();
    for (int i = 1; i <= steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      X_WH.push_back({from.p + s * by, RotationExp(s * turn) * from.q});
    }
  };
  go(Vec3(0.0, 0.0, -0.25), Vec3::Zero(), 200);
  for (int i = 0; i < 20; ++i)
    go(Vec3(0.05, 0.03, 0.004).cwiseProduct(random.InCube(1.0)), 0.02 * random.InCube(1.0), 40);
  const test::ContactFigures figures = test::MeasureContact(
      scene, X_WH, {.oracle_every = 1, .converge_every = 0, .settle_every = 200});
  EXPECT_GT(figures.force_rms, 1.0);
  EXPECT_EQ(BrokenLimits(figures, {.meeting_fraction = 0.0,
                                   .depth = 0.0,
                                   .arrived_fraction = 0.99,
                                   .unexplained = 0,
                                   .settled_50ms = 1.0}),
            "");
}

/// Drives a scene's first tool with one sub-step per cycle, and expects the straight path between
/// consecutive poses to be free.
void ExpectFreeWays(const Scene& scene, const Pose& start, const std::vector<Pose>& X_WH) {
  StepParameters parameters;
  parameters.features = scene.features;
  parameters.sub_steps = 1;
  const Body& tool = scene.tools.front();
  const HapticModel model(tool.tree, MakeObjects(scene), parameters, &tool.mesh);
  StepWorkspace workspace(model);
  StepState state(model);
  const test::MeshOracle oracle(scene);
  state.X_WG = state.X_WH = start;
  for (std::size_t i = 0; i < X_WH.size(); ++i) {
    const Pose from = state.X_WG;
    HapticStep(model, X_WH[i], state, workspace);
    const Pose& to = state.X_WG;
    const Vec3 p = from * model.reference(), v = to * model.reference() - p;
    const Vec3 phi = RotationLog(to.q * from.q.conjugate());
    if (v == Vec3::Zero() && phi == Vec3::Zero()) continue;
    for (int k = 1; k <= 10; ++k) {
      const double s = k / 10.0;
      const Quat q = RotationExp(s * phi) * from.q;
      ASSERT_FALSE(oracle.Meet({p + s * v - q * model.reference(), q}))
          << "step " << i << ", at " << s << " of the way";
    }
  }
}

TEST(MeshContactHands, LeaveTheWholeWayOfASubStepFree) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    const std::vector<Pose> X_WH = WildHand(c.size, 3, 500);
    ExpectFreeWays(c.make(), X_WH.front(), X_WH);
  }
}

// The plane of two edges that cross at a few degrees turns up to fifty times as fast as the tool.
TEST(MeshContactHands, LeaveTheWholeWayFreeWhereEdgesAreNearlyParallel) {
  const double bar = 0.01, touching = 2.0 * bar * M_SQRT1_2;
  Scene scene = MeshScene(MakeBox(Vec3(0.03, bar, bar)), MakeBox(Vec3(0.1, bar, bar)));
  const Quat on_edge = RotationExp(Vec3(M_PI / 4, 0.0, 0.0));
  scene.objects[0].X_WB.q = on_edge;
  for (const std::uint64_t seed : {5u, 7u, 8u, 10u}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    std::vector<Pose> X_WH;
    for (int place = 0; place < 200; ++place) {
      const double yaw = random.Uniform(-0.15, 0.15), roll = random.Uniform(-0.3, 0.3);
      const double x = random.Uniform(-4e-3, 4e-3), y = random.Uniform(-6e-4, 6e-4);
      const Quat q = RotationExp(Vec3(0.0, 0.0, yaw)) * RotationExp(Vec3(roll, 0.0, 0.0)) * on_edge;
      X_WH.insert(X_WH.end(), 15, Pose{Vec3(x, y, touching - random.Uniform(0.0, 2e-3)), q});
    }
    ExpectFreeWays(
        scene, {Vec3(0.0, 0.0, touching + 1e-4), RotationExp(Vec3(0, 0, 0.05)) * on_edge}, X_WH);
  }
}

}  // namespace
}  // namespace palpate
