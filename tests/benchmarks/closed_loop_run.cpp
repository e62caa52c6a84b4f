#include "tests/benchmarks/closed_loop_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/station/station_core.h"
#include "common/error.h"
#include "common/math/rotation.h"
#include "devices/simulated/simulated_phantom.h"
#include "scenes/catalogue.h"
#include "scenes/pose_script.h"
#include "scenes/shapes.h"
#include "scenes/sphere_tree_builder.h"
#include "server/session/scene_model.h"
#include "server/session/servo_loop.h"
#include "tests/support/past_the_limiter.h"
#include "tests/support/simulated_link.h"
#include "tests/support/uncontrolled_limiter.h"

namespace palpate::bench {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kTick_s = 1e-3;
constexpr double kMillimetre = 1e-3;

/// The arm under test, with the limiter's energy stage or without: then what the station asks for
/// goes through the same chain but for that stage, and what the station's limiter made is left.
class ArmUnderTest final : public Device {
 public:
  ArmUnderTest(SimulatedPhantom& phantom, bool passivity) : phantom_(phantom) {
    if (passivity) return;
    uncontrolled_.emplace(WrenchLimits::Of(phantom.info()));
    uncontrolled_->Enable(true);
  }
  void SetCore(const StationCore& core) { core_ = &core; }

  const DeviceInfo& info() const override { return phantom_.info(); }
  DeviceSample Read() noexcept override { return phantom_.Read(); }
  void Apply(const LimitedWrench& wrench) noexcept override {
    applied_ = uncontrolled_ ? uncontrolled_->Limit(core_->asked()) : wrench.wrench();
    test::PastTheLimiter::Apply(phantom_, applied_);
  }
  const Wrench& applied() const { return applied_; }

 private:
  SimulatedPhantom& phantom_;
  std::optional<test::UncontrolledLimiter> uncontrolled_;
  const StationCore* core_ = nullptr;
  Wrench applied_;
};

/// Way of a point, peak to peak, over a span of time.
class Span {
 public:
  void Add(const Vec3& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  double way() const { return (high_ - low_).maxCoeff(); }

 private:
  Vec3 low_ = Vec3::Constant(1e9), high_ = Vec3::Constant(-1e9);
};

}  // namespace

ClosedLoopScene MakeClosedLoopScene(const std::string& name) {
  ClosedLoopScene out;
  out.name = name;
  if (name == "wall") {
    Body& ball = out.scene.tools.emplace_back();
    ball.name = "ball";
    ball.mesh = MakeSphere(5 * kMillimetre, 320);
    ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 5 * kMillimetre});
    Body& plate = out.scene.objects.emplace_back();
    plate.name = "plate";
    plate.mesh = MakeBox(Vec3(80, 20, 80) * kMillimetre);
    plate.tree = BuildSphereTree(plate.mesh, 2048);
    plate.X_WB.p = Vec3(0, -10 * kMillimetre, 0);
    out.scene.name = name;
    out.touching.p = Vec3(0, 5 * kMillimetre, 0);
    out.above.p = Vec3(0, 15 * kMillimetre, 0);
    out.normal = Vec3::UnitY();
    return out;
  }
  if (name != "bunny") throw UsageError("closed-loop: --scene '" + name + "': give wall or bunny");
  out.scene = LoadScene("bunny-bunny");
  // Where the scene's own script presses on the back.
  const PoseScript script = PoseScript::Load(ScriptFileBeside("bunny-bunny"));
  out.above = script.At(0.4);
  out.touching = script.At(0.8);
  out.normal = Vec3::UnitY();
  return out;
}

ClosedLoopFigures RunClosedLoop(const ClosedLoopScene& scene, const ClosedLoopCase& c) {
  Scene stiffened = scene.scene;
  // Both springs by the same factor: the tool turns as it did.
  const double factor = c.stiffness_N_per_m / stiffened.coupling.stiffness;
  stiffened.coupling.stiffness *= factor;
  stiffened.coupling.torsional_stiffness *= std::min(factor, 1.0);
  const HapticModel model = MakeModel(stiffened, stiffened.tools.front(), MakeObjects(stiffened));

  const HandImpedance& impedance = PublishedHandOf(c.hand).impedance;
  const double depth = scene.press_N / impedance.stiffness_N_m;
  const auto pressed = [&](double share) {
    return Pose{scene.touching.p - share * depth * scene.normal, scene.touching.q};
  };
  const double t_tap = kClosedLoopPress_s, t_still = t_tap + kClosedLoopTap_s;
  const double end = t_still + kClosedLoopWatch_s;
  SimulatedPhantom phantom(
      PhantomSheetOf(c.arm),
      SimulatedHand(ScriptPlayer(PoseScript({{0.0, scene.above, "down"},
                                             {0.8, pressed(1.0), "press"},
                                             {t_tap, pressed(1.0), "tap"},
                                             {t_tap + 1e-3, pressed(0.3), "tap"},
                                             {t_still, pressed(0.3), "tap"},
                                             {t_still + 1e-3, pressed(1.0), "hold"}}),
                                 false),
                    impedance),
      scene.above);
  ArmUnderTest arm(phantom, c.passivity);
  StationCore core(arm);
  arm.SetCore(core);
  core.EnableForces(true);
  core.EnableLocalModel(c.local_model);
  core.SetSpring(
      {model.parameters().stiffness, model.parameters().torsional_stiffness, model.reference()});

  ServoLoop server(model);
  StepWorkspace workspace(model);
  server.Start(ResolveStart(model, scene.above, workspace).X_WG);
  test::LinkConditions way;
  way.delay_ns = std::llround(0.5e6 * c.delay_ms);
  way.jitter_ns = std::llround(0.5e6 * c.jitter_ms);
  way.loss = c.loss;
  test::SimulatedLink<wire::HapticPose, wire::Wrench> link(c.seed, way);

  ClosedLoopFigures figures;
  Span last;
  double given_J = 0.0;
  int watched = 0, touching = 0;
  const int ticks = static_cast<int>(std::lround(end / kTick_s));
  for (int i = 1; i <= ticks; ++i) {
    const std::int64_t now_ns = kTick_ns * i;
    // The server answers when a pose arrives; one that is sent in this tick is answered after it,
    // as in life: a tick does not wait.
    while (const auto arrival_ns = link.up.next_arrival_ns()) {
      if (*arrival_ns > now_ns) break;
      const wire::HapticPose pose = *link.up.Receive(now_ns);
      wire::Wrench answer{};
      if (server.OnPose(pose, answer)) link.down.Send(*arrival_ns, answer);
    }
    const OutgoingPose sensed = core.Sense(now_ns, true);
    wire::HapticPose pose{};
    pose.pose_sequence = sensed.sequence;
    pose.sample_time_ns = sensed.sample_time_ns;
    wire::FromPose(sensed.sample.X_WH, pose.position_m, pose.orientation_wxyz);
    link.up.Send(now_ns, pose);
    while (const auto arrival_ns = link.down.next_arrival_ns()) {
      if (*arrival_ns > now_ns) break;
      core.Take(ToReply(*link.down.Receive(now_ns), *arrival_ns));
    }
    const Pose from = phantom.pose();
    core.Act(now_ns);
    const Pose& to = phantom.pose();
    const Wrench& applied = arm.applied();
    given_J += applied.force.dot(to.p - from.p) +
               applied.torque.dot(RotationLog(to.q * from.q.conjugate()));
    figures.energy_J = std::max(figures.energy_J, given_J);

    const double left = end - kTick_s * i;
    if (left < kClosedLoopCycle_s) {
      last.Add(to.p);
      figures.mean_force_N += applied.force.norm();
      touching += applied.force.dot(scene.normal) > 0.0;
      ++watched;
    }
  }
  figures.mean_force_N /= watched;
  figures.limit_cycle_mm = 1e3 * last.way();
  figures.beyond_region =
      static_cast<double>(core.totals().beyond_region) / static_cast<double>(ticks);
  const double two_steps = 2.0 * phantom.info().position_resolution_m;
  figures.stable = touching == watched && last.way() <= two_steps;
  return figures;
}

double MaxStableStiffness(const ClosedLoopScene& scene, ClosedLoopCase c) {
  const auto stable = [&](double stiffness) {
    c.stiffness_N_per_m = stiffness;
    return RunClosedLoop(scene, c).stable;
  };
  if (!stable(kLeastStiffness)) return 0.0;
  // Upwards until it fails, so that what lies above an instability does not count.
  double low = kLeastStiffness, high = low;
  do {
    low = high;
    high = std::min(1.3 * low, kStiffest);
    if (low >= kStiffest) return kStiffest;
  } while (stable(high));
  while (high > 1.02 * low) {
    const double middle = std::sqrt(low * high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace palpate::bench
