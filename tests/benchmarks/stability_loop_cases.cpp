// Cases of the step in its loops: a servo loop with a bad link, and an arm and hand with delay.
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>

#include <spdlog/fmt/fmt.h>

#include "client/station/station_core.h"
#include "common/dds/wire.h"
#include "common/math/rotation.h"
#include "devices/simulated/simulated_phantom.h"
#include "server/session/servo_loop.h"
#include "tests/benchmarks/stability_case.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

using test::Random;

constexpr std::int64_t kServoTick_ns = 1'000'000;

/// A plate whose top face is y = 0.
Solid CoarseFloor() {
  return Box({60 * kMillimetre, 10 * kMillimetre, 60 * kMillimetre}, 2048,
             {Vec3(0, -5 * kMillimetre, 0), Quat::Identity()});
}

wire::HapticPose Sample(std::uint64_t sequence, const Pose& X_WH) {
  wire::HapticPose pose{};
  pose.pose_sequence = sequence;
  pose.sample_time_ns = kServoTick_ns * static_cast<std::int64_t>(sequence);
  wire::FromPose(X_WH, pose.position_m, pose.orientation_wxyz);
  return pose;
}

/// A hand presses a box on a plate, and each third of its poses comes late, twice, out of order,
/// not finite, not normalised, from elsewhere, or not at all.  The force fades by a twentieth of
/// its full value with each unusable pose, returns ten times slower, and otherwise follows the
/// hand: the figure is its change relative to what these rules allow.
void BadLink(CaseRun& run) {
  constexpr double kStiffness = 1000.0, kNaN = std::numeric_limits<double>::quiet_NaN();
  Trial trial(run, Box({12 * kMillimetre, 6 * kMillimetre, 9 * kMillimetre}, 256), {CoarseFloor()});
  ServoLoop loop(trial.model());
  loop.Start({Vec3(0, 4 * kMillimetre, 0), Quat::Identity()});
  Random random(70);
  std::uint64_t sequence = 0;
  wire::HapticPose before{};
  Vec3 last_force = Vec3::Zero(), last_hand = Vec3::Zero();
  for (int i = 0; run.Goes(); ++i) {
    ++sequence;
    const Vec3 hand(5 * kMillimetre * std::sin(0.002 * i),
                    kMillimetre * (1.0 + 2.0 * std::cos(0.005 * i)), 0.0);
    wire::HapticPose pose = Sample(sequence, {hand, Quat::Identity()});
    const wire::HapticPose sound = pose;
    bool lost = false;
    switch (random.Below(24)) {
      case 0:
        pose = before;
        break;  // doubled, or late
      case 1:
        pose.pose_sequence -= 3;
        break;  // out of order
      case 2:
        pose.position_m[random.Below(3)] = kNaN;
        break;
      case 3:
        pose.orientation_wxyz[random.Below(4)] = 1.0 / 0.0;
        break;
      case 4:
        pose.orientation_wxyz[0] = 1.3;
        break;  // not normalised
      case 5:
        pose.orientation_wxyz[0] = 0.0;
        break;  // no length
      case 6:
        pose.position_m[random.Below(3)] = 1e300;
        break;
      case 7:
        pose.position_m[1] += 0.3;
        break;  // from elsewhere
      case 8:
        lost = true;
        break;
      default:
        break;
    }
    before = sound;
    if (lost) continue;
    wire::Wrench answer{};
    if (!loop.OnPose(pose, answer)) continue;
    const Vec3 force = wire::ToWrench(answer).force;
    const Pose X_WG{Vec3(answer.graphic_position_m[0], answer.graphic_position_m[1],
                         answer.graphic_position_m[2]),
                    Quat(answer.graphic_orientation_wxyz[0], answer.graphic_orientation_wxyz[1],
                         answer.graphic_orientation_wxyz[2], answer.graphic_orientation_wxyz[3])};
    trial.Check(X_WG, wire::ToWrench(answer));
    run.tunnelled += X_WG.p.y() < 0.0;
    // 4 N is the most that this hand can press.
    const double allowed = 4.0 / 20.0 + kStiffness * (hand - last_hand).norm();
    run.Worst((force - last_force).norm() / allowed);
    last_force = force;
    if ((answer.faults & (kFaultBadPose | kFaultPoseRejected)) == 0) last_hand = hand;
  }
}

/// Damping of hand and device together, which dissipates the energy that delay generates.
double LoopDamping() {
  return HandImpedance{}.damping_N_s_m + PhantomPremium30().dynamics.viscous_N_s_m;
}

/// A spring of stiffness k whose force is late by T generates energy like a negative damper k T
/// (from its phase at low frequency), so k T < b is necessary; half of that is used.
double StiffnessFor(double delay_s) {
  return std::min(1000.0, 0.5 * LoopDamping() / std::max(delay_s, 1e-3));
}

/// A simulated arm and hand behind the device's limiter, and answers that come `delay_ms` late: the
/// hand comes down on a plate, presses with about 1 N and tries to hold still.  The figure is its
/// motion in the second half.
void ClosedLoop(CaseRun& run, int delay_ms) {
  Trial trial(run, Box({12 * kMillimetre, 6 * kMillimetre, 9 * kMillimetre}, 256), {CoarseFloor()},
              StiffnessFor(1e-3 * delay_ms));
  constexpr double kRound_s = 6.0;
  const Pose above{Vec3(0, 15 * kMillimetre, 0), Quat::Identity()};
  const Pose deep{Vec3(0, -5 * kMillimetre, 0), RotationExp(Vec3(0.02, 0.0, 0.03))};
  while (run.Goes()) {
    SimulatedPhantom phantom(
        PhantomPremium30(),
        SimulatedHand(ScriptPlayer(PoseScript({{0.0, above, "down"}, {0.8, deep, "hold"}}), false),
                      HandImpedance{}),
        above);
    WrenchLimiter limiter(WrenchLimits::Of(phantom.info()));
    limiter.Enable(true);
    limiter.SetStiffness(StiffnessFor(1e-3 * delay_ms));
    ServoLoop loop(trial.model());
    loop.Start(above);
    std::deque<Wrench> under_way(static_cast<std::size_t>(delay_ms));
    double low = 1e9, high = -1e9;
    Wrench felt;
    for (int tick = 1; tick <= static_cast<int>(1e3 * kRound_s); ++tick) {
      const DeviceSample sample = phantom.Read();
      const Pose& X_WH = sample.X_WH;
      wire::Wrench answer{};
      loop.OnPose(Sample(static_cast<std::uint64_t>(tick), X_WH), answer);
      const Vec3 p_WG(answer.graphic_position_m[0], answer.graphic_position_m[1],
                      answer.graphic_position_m[2]);
      const Quat q_WG(answer.graphic_orientation_wxyz[0], answer.graphic_orientation_wxyz[1],
                      answer.graphic_orientation_wxyz[2], answer.graphic_orientation_wxyz[3]);
      trial.Check({p_WG, q_WG}, wire::ToWrench(answer));
      run.tunnelled += p_WG.y() < 0.0;
      under_way.push_back(ShiftToHandle(wire::ToWrench(answer), X_WH.q, trial.model().reference()));
      felt = under_way.front();
      under_way.pop_front();
      const double age_s = 1e-3 * delay_ms;
      phantom.Apply(limiter.Limit({felt, {}, X_WH, sample.V_WH, 0.0, age_s, 1e-3}));
      if (tick < 500 * kRound_s) continue;
      low = std::min(low, phantom.pose().p.y());
      high = std::max(high, phantom.pose().p.y());
    }
    run.Worst(1e6 * (high - low));
    if (!(felt.force.y() > 0.2)) run.figure = 1e9;  // without a force the case is meaningless
  }
}

}  // namespace

std::vector<StabilityCase> LoopCases() {
  std::vector<StabilityCase> cases;
  cases.push_back({.name = "bad-link",
                   .what = "change of the sent force over what a fade and the hand allow",
                   .reason = "a force fades by a twentieth with each pose that cannot be used, and "
                             "a good pose may change it by the stiffness times the hand's way",
                   .bound = 1.0,
                   .unit = "",
                   .share = 1,
                   .run = BadLink});
  for (const int delay_ms : {0, 1, 2, 5, 10, 20}) {
    const double stiffness = StiffnessFor(1e-3 * delay_ms);
    cases.push_back(
        {.name = fmt::format("closed-loop-{}ms", delay_ms),
         .what = fmt::format("motion of a hand that holds still, at {:.0f} N/m", stiffness),
         .reason = "two steps of the encoder: a limit cycle would be felt.  The stiffness is at "
                   "most half of b / T, beyond which delay alone makes any loop unstable",
         .bound = 2e6 * PhantomPremium30().info.position_resolution_m,
         .unit = "um",
         .share = 0.5,
         .least = 6000,
         .run = [=](CaseRun& run) { ClosedLoop(run, delay_ms); }});
  }
  return cases;
}

}  // namespace palpate::bench
