// Tools that slide over flat plates.  The truth: without friction a force along the normal, the
// spring's stiffness times the depth; in steady sliding mu_d of it against the motion.
#include <algorithm>
#include <cmath>
#include <memory>

#include "common/math/rotation.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/benchmarks/truth.h"
#include "tests/support/flat_plates.h"
#include "tests/support/plain_tools.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

using test::Random;

constexpr double kStatic = 0.5, kDynamic = 0.3;

/// A hand that presses a tool on a plate and slides it.
struct Slide {
  Scene scene;
  std::vector<Pose> X_WH;              ///< one per millisecond; the first is free
  std::vector<double> depth;           ///< of the tool's lowest point below the plate's plane [m]
  Vec3 normal = Vec3::UnitY(), along;  ///< of the plate, of the motion; unit, in W
  double speed = 0.0;                  ///< [m/s]
  double reach = 0.0;                  ///< of the tool from its centroid [m]
  bool level = true;                   ///< whether the tool's foot is parallel to the plate
  std::size_t steady = 0;              ///< from this sample on a tool that rubs must slide steadily
};

double Decades(Random& random, double low, double high) {
  return low * std::pow(high / low, random.Uniform(0.0, 1.0));
}

/// How a hand moves over the plate, in the plate's frame.
struct Motion {
  double depth, speed, angle, yaw, turn_rate;
  double x, z;  ///< where it presses [m]
  Quat tilt = Quat::Identity();
};

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
  const bool turns = random.Below(3) == 0, tilts = random.Below(2) == 0;
  const double rate = random.Uniform(-1.0, 1.0), tilt = random.Uniform(-0.1, 0.1);
  const double about = random.Uniform(-M_PI, M_PI);
  if (rubs) return m;
  if (turns) m.turn_rate = rate;
  if (tilts && !is_ball) m.tilt = RotationExp(tilt * Vec3(std::cos(about), 0.0, std::sin(about)));
  return m;
}

/// Samples the motion: down for 0.3 s from 1 mm above, then along.
void Sample(const Motion& m, bool rubs, Slide& slide) {
  constexpr int kDown = 300;
  constexpr double kAbove = 1e-3, kTremor = 20e-6, kTremorHz = 8.0;
  const Body& tool = slide.scene.tools.front();
  const Pose& X_WP = slide.scene.objects.front().X_WB;
  const bool is_ball = tool.tree.leaves() == 1;
  const Vec3 along(std::cos(m.angle), 0.0, std::sin(m.angle));
  slide.along = X_WP.q * along;
  slide.normal = X_WP.q * Vec3::UnitY();
  slide.speed = m.speed;
  // Enough for the spring to overcome static friction, and for what follows to settle.
  const double run_in = rubs ? (kStatic + 0.2) * m.depth + 3e-4 : 0.0;
  const double way = run_in + (rubs ? 0.004 : 0.02);
  slide.steady = static_cast<std::size_t>(kDown + std::ceil(1e3 * run_in / m.speed));
  const int steps = std::min(static_cast<int>(1e3 * way / m.speed) + kDown,
                             rubs ? static_cast<int>(slide.steady) + 1500 : 3000);
  for (int i = 0; i < steps; ++i) {
    const double t = 1e-3 * i, slid = 1e-3 * m.speed * std::max(0, i - kDown);
    const double pressed = std::min(1.0, static_cast<double>(i) / kDown);
    const double depth =
        -kAbove + (m.depth + kAbove) * pressed + kTremor * std::sin(2.0 * M_PI * kTremorHz * t);
    const Quat q = RotationExp((m.yaw + m.turn_rate * t) * Vec3::UnitY()) * m.tilt;
    double lowest = 0.0;
    for (const Vec3& v : tool.mesh.vertices) lowest = std::min(lowest, (q * v).y());
    if (is_ball) lowest = -tool.tree.leaf_radius[0];
    const Vec3 at = Vec3(m.x, -lowest - depth, m.z) + slid * along;
    slide.X_WH.push_back(X_WP * Pose{at, q});
    slide.depth.push_back(depth);
  }
}

/// Returns a seed for a case and a seed, so that no two cases have hands in common (FNV-1a).
std::uint64_t SeedOf(std::string_view name, std::uint64_t seed) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash + seed;
}

Slide MakeSlide(std::string_view tessellation, std::string_view tool, std::uint64_t seed,
                bool rubs) {
  Random random(seed);
  Slide slide;
  slide.scene.tools.push_back(test::MakePlainTool(tool, random.Bits()));
  Body plate = test::MakeSolidBody("plate", test::MakePlate(tessellation, random.Bits()));
  if (rubs) {
    slide.scene.features.friction = FrictionModel::kCoulomb;
    plate.materials = {{.static_friction = kStatic, .dynamic_friction = kDynamic}};
  }
  if (random.Below(2) == 0) plate.X_WB = {random.InCube(0.2), random.Rotation()};
  slide.scene.objects.push_back(std::move(plate));
  const Body& made = slide.scene.tools.front();
  for (const Vec3& v : made.mesh.vertices) {
    slide.reach = std::max(slide.reach, (v - made.tree.centroid).norm());
  }
  const Motion motion = MakeMotion(random, rubs, tool == "ball");
  slide.level = motion.tilt.vec().isZero();
  Sample(motion, rubs, slide);
  return slide;
}

/// Steps through a slide: calls visit(sample, report).
template <class Visit>
void Drive(const Slide& slide, Visit visit) {
  const Body& tool = slide.scene.tools.front();
  const HapticModel model = MakeModel(slide.scene, tool, MakeObjects(slide.scene));
  StepWorkspace workspace(model);
  StepState state(model);
  state.X_WG = slide.X_WH.front();
  for (std::size_t i = 0; i < slide.X_WH.size(); ++i) {
    visit(i, HapticStep(model, slide.X_WH[i], state, workspace));
  }
}

bool Late(const StepReport& report) {
  return (report.faults & kFaultTargetFar) != 0;
}

void SlideSmoothly(const Slide& slide, std::uint64_t seed, Tally& tally) {
  constexpr double kFelt = 0.01;  // [N]
  const double k = slide.scene.coupling.stiffness, delta = slide.scene.tuning.separation;
  double sideways = 0.0, normal = 0.0, arrived_normal = 0.0, torque = 0.0;
  int late = 0, faults = 0;
  Drive(slide, [&](std::size_t i, const StepReport& report) {
    const Vec3& force = report.wrench.force;
    const double along_normal = force.dot(slide.normal);
    // Not max and <, for which a value that is no number would be none.
    const auto worst = [](double& value, double now) { value = now <= value ? value : now; };
    worst(sideways, (force - along_normal * slide.normal).norm());
    late += Late(report);
    faults += (report.faults & ~kFaultTargetFar) != 0;
    if (!slide.level) return;
    const double off = std::abs(along_normal - k * std::max(0.0, slide.depth[i] + delta));
    worst(normal, off);
    worst(torque, report.wrench.torque.norm());
    if (!Late(report)) worst(arrived_normal, off);
  });
  tally.Count("slides", 1);
  tally.Count("over 0.01 N", !(sideways <= kFelt));
  tally.Most("sideways N", sideways, seed);
  tally.Count("cycles", static_cast<double>(slide.X_WH.size()));
  tally.Count("late", late);
  tally.Count("faults", faults);
  // Zero of a tool that is not level.
  tally.Most("normal off N", normal, seed);
  tally.Most("arrived N", arrived_normal, seed);
  tally.Most("torque N m", torque, seed);
}

/// Where all points of a foot move alike, friction is mu_d of the load against that motion.  They
/// do once a hand that does not turn slides steadily: the tool then tilts as far as friction tips
/// it, and no further.  Turning by w adds at most w times the reach to the hand's speed, so cycles
/// in which this is over a thousandth of it are not judged but counted: the direction of the others
/// is within 0.06 degrees, and mu within 5e-7.
void SlideRoughly(const Slide& slide, std::uint64_t seed, Tally& tally) {
  constexpr double kTurning = 1e-3, kOff = 0.01;
  const double k = slide.scene.coupling.stiffness;
  double least = INFINITY, most = 0.0, direction = 0.0, change = 0.0;
  int touching = 0, judged = 0, turning = 0, late = 0, unsolved = 0, lowered = 0;
  Vec3 last_force = Vec3::Zero();
  Quat last_q = slide.X_WH.front().q;
  Drive(slide, [&](std::size_t i, const StepReport& report) {
    touching += report.contacts > 0;
    late += Late(report);
    unsolved += report.diagnostics.friction_unsolved > 0;
    lowered += report.diagnostics.friction_lowered > 0;
    const Vec3& force = report.wrench.force;
    const double load = force.dot(slide.normal);
    const Vec3 rub = force - load * slide.normal;
    const double turn = RotationLog(report.X_WG.q * last_q.conjugate()).norm();
    if (i >= slide.steady) {
      // Beyond what the hand itself changes.
      const double by_hand =
          k * std::abs(slide.depth[i] - slide.depth[i - 1]) * std::hypot(1.0, kDynamic);
      change = std::max(change, ((force - last_force).norm() - by_hand) / load);
      const bool turns = turn * slide.reach > kTurning * 1e-3 * slide.speed;
      turning += turns;
      if (!turns) {
        ++judged;
        const double mu = rub.norm() / load;
        least = std::min(least, mu);
        most = std::max(most, mu);
        if (mu > 0.1 * kDynamic) {
          const double sine = rub.cross(slide.along).norm(), cosine = -rub.dot(slide.along);
          direction = std::max(direction, 180.0 / M_PI * std::atan2(sine, cosine));
        }
      }
    }
    last_force = force;
    last_q = report.X_WG.q;
  });
  tally.Count("slides", 1);
  tally.Count("1 % off",
              judged > 0 && !(least > (1.0 - kOff) * kDynamic && most < (1.0 + kOff) * kDynamic));
  tally.Least("mu least", least, seed);
  tally.Most("mu most", most, seed);
  tally.Most("direction deg", direction, seed);
  tally.Most("change N/N", change, seed);
  tally.Count("touching", touching);
  tally.Count("unsolved", unsolved);
  tally.Count("lowered", lowered);
  tally.Count("late", late);
  tally.Count("judged", judged);
  tally.Count("turning", turning);
}

}  // namespace

std::vector<TruthCase> FlatTruths() {
  std::vector<TruthCase> cases;
  for (const bool rubs : {false, true}) {
    for (const std::string_view plate : test::kTessellations) {
      for (const std::string_view tool : test::kPlainTools) {
        const std::string name =
            (rubs ? "flat-friction/" : "flat/") + std::string(plate) + "/" + std::string(tool);
        cases.push_back({name, [=](std::uint64_t seed, Tally& tally) {
                           const Slide slide = MakeSlide(plate, tool, SeedOf(name, seed), rubs);
                           (rubs ? SlideRoughly : SlideSmoothly)(slide, seed, tally);
                         }});
      }
    }
  }
  return cases;
}

}  // namespace palpate::bench
