#include "tests/benchmarks/closed_loop_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/station/station_core.h"
#include "common/error.h"
#include "common/json/pose_script.h"
#include "common/math/rotation.h"
#include "devices/simulated/simulated_phantom.h"
#include "scenes/catalogue.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/benchmarks/stability_case.h"
#include "tests/support/past_the_limiter.h"
#include "tests/support/simulated_link.h"
#include "tests/support/uncontrolled_limiter.h"

namespace palpate::bench {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kTick_s = 1e-3;
/// The arm under test, with or without the limiter's energy stage.  Without it, the wrench that the
/// station requests goes through the same chain except for that stage, and the output of the
/// station's own limiter is ignored.
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

/// Measures the energy that a device gives a hand; exact, as the wrench is held during a motion.
class PortEnergy {
 public:
  void Add(const Wrench& held, const Pose& from, const Pose& to) {
    given_J_ +=
        held.force.dot(to.p - from.p) + held.torque.dot(RotationLog(to.q * from.q.conjugate()));
    most_J_ = std::max(most_J_, given_J_);
  }
  double given_J() const { return given_J_; }
  double most_J() const { return most_J_; }

 private:
  double given_J_ = 0.0, most_J_ = 0.0;
};

/// Measures a vector's motion over a time span: peak to peak, along the axis of greatest motion.
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
    out.objects = MakeObjects(out.scene);
    return out;
  }
  if (name != "bunny") throw UsageError("closed-loop: --scene '" + name + "': give wall or bunny");
  out.scene = LoadScene("bunny-bunny");
  // The place where the scene's own script presses on the back.
  const PoseScript script = PoseScript::Load(ScriptFileBeside("bunny-bunny"));
  out.above = script.At(0.4);
  out.touching = script.At(0.8);
  out.normal = Vec3::UnitY();
  out.objects = MakeObjects(out.scene);
  return out;
}

ClosedLoopFigures RunClosedLoop(const ClosedLoopScene& scene, const ClosedLoopCase& c) {
  Scene stiffened = scene.scene;
  // Scales both springs by the same factor: the torsional spring limits the stiffness of a contact
  // beside the tool's reference point, which would otherwise stay soft.
  const double factor = c.stiffness_N_per_m / stiffened.coupling.stiffness;
  stiffened.coupling.stiffness *= factor;
  stiffened.coupling.torsional_stiffness *= factor;
  const HapticModel model = MakeModel(stiffened, stiffened.tools.front(), scene.objects);

  const HandImpedance& impedance = PublishedHandOf(c.hand).impedance;
  const double depth = scene.press_N / impedance.stiffness_N_m;
  const auto pressed = [&](double share) {
    return Pose{scene.touching.p - share * depth * scene.normal, scene.touching.q};
  };
  const double t_tap = kClosedLoopPress_s, t_still = t_tap + kClosedLoopTap_s;
  const double t_lift = t_still + kClosedLoopWatch_s, end = t_lift + kClosedLoopLift_s;
  SimulatedPhantom phantom(
      PhantomSheetOf(c.arm),
      SimulatedHand(ScriptPlayer(PoseScript({{0.0, scene.above, "down"},
                                             {0.8, pressed(1.0), "press"},
                                             {t_tap, pressed(1.0), "tap"},
                                             {t_tap + 1e-3, pressed(0.3), "tap"},
                                             {t_still, pressed(0.3), "tap"},
                                             {t_still + 1e-3, pressed(1.0), "hold"},
                                             {t_lift, pressed(1.0), "lift"},
                                             {end, scene.above, "away"}}),
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
  test::LinkConditions each_way;
  each_way.delay_ns = std::llround(0.5e6 * c.delay_ms);
  each_way.jitter_ns = std::llround(0.5e6 * c.jitter_ms);
  each_way.loss = c.loss;
  test::SimulatedLink<wire::HapticPose, wire::Wrench> link(c.seed, each_way);

  ClosedLoopFigures figures;
  PortEnergy energy, seen;
  Pose last_read;
  Span way, turn;
  Quat q_still = scene.touching.q;
  double asked_N = 0.0;
  int watched = 0, touching = 0;
  const int ticks = static_cast<int>(std::lround(end / kTick_s));
  for (int i = 1; i <= ticks; ++i) {
    const std::int64_t now_ns = kTick_ns * i;
    // The server answers when a pose arrives.  A pose sent in this tick is answered after the tick,
    // as in reality, because a tick does not wait.
    while (const auto arrival_ns = link.up.next_arrival_ns()) {
      if (*arrival_ns > now_ns) break;
      const wire::HapticPose pose = *link.up.Receive(now_ns);
      wire::Wrench answer{};
      if (server.OnPose(pose, answer)) link.down.Send(*arrival_ns, answer);
    }
    const OutgoingPose sensed = core.Sense(now_ns, true);
    if (i > 1) seen.Add(arm.applied(), last_read, sensed.sample.X_WH);
    last_read = sensed.sample.X_WH;
    wire::HapticPose pose{};
    pose.pose_sequence = sensed.sequence;
    pose.sample_time_ns = sensed.sample_time_ns;
    wire::FromPose(sensed.X_WH, pose.position_m, pose.orientation_wxyz);
    link.up.Send(now_ns, pose);
    while (const auto arrival_ns = link.down.next_arrival_ns()) {
      if (*arrival_ns > now_ns) break;
      core.Take(ToReply(*link.down.Receive(now_ns), *arrival_ns));
    }
    const Pose from = phantom.pose();
    core.Act(now_ns);
    const Pose& to = phantom.pose();
    energy.Add(arm.applied(), from, to);
    const double left = t_lift - kTick_s * i;
    if (left >= 0.0 && left < kClosedLoopCycle_s) {
      ++watched;
      way.Add(to.p);
      turn.Add(RotationLog(to.q * q_still.conjugate()));
      figures.mean_force_N += arm.applied().force.norm();
      asked_N += core.asked().wanted.force.norm();
      touching += arm.applied().force.dot(scene.normal) > 0.0;
    }
  }
  figures.rendered = asked_N > 0.0 ? figures.mean_force_N / asked_N : 0.0;
  figures.mean_force_N /= watched;
  figures.energy_J = energy.most_J();
  figures.energy_end_J = energy.given_J();
  figures.energy_seen_J = seen.most_J();
  figures.limit_cycle_mm = 1e3 * way.way();
  figures.limit_cycle_deg = 180.0 / M_PI * turn.way();
  figures.beyond_region =
      static_cast<double>(core.totals().beyond_region) / static_cast<double>(ticks);
  const DeviceInfo& info = phantom.info();
  figures.stable = touching == watched && way.way() <= 2.0 * info.position_resolution_m &&
                   turn.way() <= 2.0 * info.rotation_resolution_rad;
  return figures;
}

ZWidth MeasureZWidth(const ClosedLoopScene& scene, ClosedLoopCase c) {
  ZWidth width;
  const auto stable = [&](double stiffness) {
    c.stiffness_N_per_m = stiffness;
    const ClosedLoopFigures figures = RunClosedLoop(scene, c);
    if (figures.stable) {
      width = {stiffness, std::max(width.felt_N_per_m, figures.rendered * stiffness)};
    }
    return figures.stable;
  };
  if (!stable(kLeastStiffness)) return width;
  // Increases the stiffness until the loop is unstable; stable values beyond that do not count.
  double high = kLeastStiffness;
  do {
    if (high >= kStiffest) return width;
    high = std::min(1.3 * high, kStiffest);
  } while (stable(high));
  while (high > 1.02 * width.stiffness_N_per_m) {
    const double middle = std::sqrt(width.stiffness_N_per_m * high);
    if (!stable(middle)) high = middle;
  }
  return width;
}

}  // namespace palpate::bench
