// Tools that slide over flat plates.  The truth: without friction a force along the normal, the
// spring's stiffness times the depth; in steady sliding mu_d of it against the motion.
#include <algorithm>
#include <cmath>
#include <memory>

#include "common/math/rotation.h"
#include "tests/benchmarks/truth.h"
#include "tests/benchmarks/truth_judges.h"
#include "tests/support/flat_plates.h"
#include "tests/support/plain_tools.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

using test::Random;

/// How a hand moves over the plate, in the plate's frame.
struct Motion {
  double depth, speed, angle, yaw, turn_rate;
  double x, z;  ///< where it presses [m]
  Quat tilt = Quat::Identity();
  double run_in = 0.0, way = 0.02;  ///< slid before the judge looks, and altogether [m]
  int most_steps = 2700;            ///< of sliding that the judge looks at
};

double Decades(Random& random, double low, double high) {
  return low * std::pow(high / low, random.Uniform(0.0, 1.0));
}

Motion MakeMotion(Random& random, bool rubs, bool is_ball) {
  Motion m{};
  m.depth = rubs ? Decades(random, 5e-4, 5e-3) : Decades(random, 5e-4, 40e-3);
  m.speed = Decades(random, 1e-3, 0.1);
  m.x = random.Uniform(-5e-3, 5e-3);
  m.z = random.Uniform(-5e-3, 5e-3);
  // Every fourth hand goes along a side of the plate, where edges fall on edges.
  const bool along_side = random.Below(4) == 0;
  const int quarter = random.Below(4);
  const double any = random.Uniform(-M_PI, M_PI);
  m.angle = along_side ? 0.5 * M_PI * quarter : any;
  m.yaw = random.Below(2) == 0 ? 0.0 : random.Uniform(-M_PI, M_PI);
  if (rubs) {
    // Enough for the spring to overcome static friction, and then eight times the length on which
    // the tool, drawn by a spring stretched by mu_d of the depth, comes into line with its hand.
    m.run_in = (kTruthStatic + 8.0 * kTruthDynamic) * m.depth + 3e-4;
    m.way = m.run_in + 4e-3;
    m.most_steps = 1500;
    return m;
  }
  const bool turns = random.Below(3) == 0, tilts = random.Below(2) == 0;
  const double rate = random.Uniform(-1.0, 1.0), tilt = random.Uniform(-0.1, 0.1);
  const double about = random.Uniform(-M_PI, M_PI);
  if (turns) m.turn_rate = rate;
  if (tilts && !is_ball) m.tilt = RotationExp(tilt * Vec3(std::cos(about), 0.0, std::sin(about)));
  return m;
}

double ReachOf(const Body& tool) {
  double reach = 0.0;
  for (const Vec3& v : tool.mesh.vertices) {
    reach = std::max(reach, (v - tool.tree.centroid).norm());
  }
  return reach;
}

/// Returns how far below its origin the lowest point of a tool is.
double LowestOf(const Body& tool, const Quat& q) {
  if (tool.tree.leaves() == 1) return tool.tree.leaf_radius[0];
  double lowest = 0.0;
  for (const Vec3& v : tool.mesh.vertices) lowest = std::max(lowest, -(q * v).y());
  return lowest;
}

constexpr int kDown = 300;  // steps

/// Samples the motion: down from 1 mm above, then along.
/// @param depth  filled in: of the tool's lowest point below the plane, at each sample.
std::vector<Pose> Sample(const Motion& m, const Body& tool, const Pose& X_WP,
                         std::vector<double>& depth) {
  constexpr double kAbove = 1e-3, kTremor = 20e-6, kTremorHz = 8.0;
  const Vec3 along(std::cos(m.angle), 0.0, std::sin(m.angle));
  const double run_in_steps = 1e3 * m.run_in / m.speed, way_steps = 1e3 * m.way / m.speed;
  const int steps = kDown + static_cast<int>(std::min(way_steps, run_in_steps + m.most_steps));
  std::vector<Pose> X_WH;
  for (int i = 0; i < steps; ++i) {
    const double t = 1e-3 * i, slid = 1e-3 * m.speed * std::max(0, i - kDown);
    const double pressed = std::min(1.0, static_cast<double>(i) / kDown);
    depth.push_back(-kAbove + (m.depth + kAbove) * pressed +
                    kTremor * std::sin(2.0 * M_PI * kTremorHz * t));
    const Quat q = RotationExp((m.yaw + m.turn_rate * t) * Vec3::UnitY()) * m.tilt;
    const Vec3 at = Vec3(m.x, LowestOf(tool, q) - depth.back(), m.z) + slid * along;
    X_WH.push_back(X_WP * Pose{at, q});
  }
  return X_WH;
}

TruthHand MakeSlide(std::string_view tessellation, std::string_view tool, std::uint64_t seed,
                    bool rubs) {
  Random random(seed);
  Scene scene;
  scene.name = "truth";
  scene.tools.push_back(test::MakePlainTool(tool, random.Bits()));
  Body plate = test::MakeSolidBody("plate", test::MakePlate(tessellation, random.Bits()));
  if (random.Below(2) == 0) plate.X_WB = {random.InCube(0.2), random.Rotation()};
  if (rubs) {
    scene.features.friction = FrictionModel::kCoulomb;
    plate.materials = {{.static_friction = kTruthStatic, .dynamic_friction = kTruthDynamic}};
  }
  const Pose X_WP = plate.X_WB;
  scene.objects.push_back(std::move(plate));
  const Motion motion = MakeMotion(random, rubs, tool == "ball");
  std::vector<double> depth;
  std::vector<Pose> X_WH = Sample(motion, scene.tools.front(), X_WP, depth);
  const Vec3 normal = X_WP.q * Vec3::UnitY();
  if (!rubs) {
    SmoothTruth truth{.axis = {normal}};
    // The force on a tool that is not level depends on how far it tips.
    if (motion.tilt.vec().isZero()) {
      for (const double d : depth) {
        truth.force.push_back(scene.coupling.stiffness *
                              std::max(0.0, d + scene.tuning.separation) * normal);
      }
    }
    return JudgedBy(SmoothJudge(std::move(truth)), std::move(scene), std::move(X_WH));
  }
  SteadySlide slide{
      .normal = normal,
      .along = X_WP.q * Vec3(std::cos(motion.angle), 0.0, std::sin(motion.angle)),
      .speed = motion.speed,
      .reach = ReachOf(scene.tools.front()),
      .stiffness = scene.coupling.stiffness,
      .steady = static_cast<std::size_t>(kDown + std::ceil(1e3 * motion.run_in / motion.speed)),
      .depth = std::move(depth)};
  const Quat start = X_WH.front().q;
  return JudgedBy(SteadyJudge(std::move(slide), start), std::move(scene), std::move(X_WH));
}

}  // namespace

std::vector<TruthCase> FlatTruths() {
  std::vector<TruthCase> cases;
  for (const bool rubs : {false, true}) {
    for (const std::string_view plate : test::kTessellations) {
      for (const std::string_view tool : test::kPlainTools) {
        const std::string name =
            (rubs ? "flat-friction/" : "flat/") + std::string(plate) + "/" + std::string(tool);
        cases.push_back({name, [=](std::uint64_t seed) {
                           return MakeSlide(plate, tool, SeedOfCase(name, seed), rubs);
                         }});
      }
    }
  }
  return cases;
}

}  // namespace palpate::bench
