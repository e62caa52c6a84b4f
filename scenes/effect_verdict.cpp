#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <Eigen/Geometry>

#include "common/math/rotation.h"
#include "common/program/forked.h"
#include "common/realtime/steady_clock.h"
#include "scenes/scene_verdict.h"

namespace palpate {
namespace {

constexpr int kCycles = 400;
/// Of the servo loop's millisecond, which all tools share.
constexpr double kSlow_s = 50e-6, kTooSlow_s = 500e-6;
/// Of the calls that are timed and compared, and a wait.
constexpr double kPatience_s = 10.0;
/// Of those that measure energy: some 130,000, at most half a millisecond each.
constexpr double kLongPatience_s = 120.0;
constexpr const char* kStep = "its function step";

/// What an effect gave along a path, and how long each call took.
struct Trial {
  std::vector<std::array<double, 12>> wrenches;
  std::vector<double> took_s;
  const char* failure = nullptr;
};

/// Lets the effect act on a hand that moves from the centre outwards and round it.
Trial Try(const Effects& effects, const Vec3& centre, double radius) {
  Trial trial;
  EffectState state = effects.Begin();
  const ForeignCall call(kStep);
  for (int i = 0; i < kCycles; ++i) {
    const double share = static_cast<double>(i) / kCycles, turn = 0.05 * i;
    const Vec3 out(std::cos(turn) * std::cos(0.3 * turn), std::sin(turn), std::sin(0.3 * turn));
    const Pose X{centre + share * radius * out, RotationExp(share * out)};
    EffectWrenches given;
    const std::int64_t began_ns = SteadyNanoseconds();
    effects.Step(X, X, Vec3::Zero(), state, given);
    trial.took_s.push_back(1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns));
    trial.failure = state.of[0].failure;
    if (trial.failure != nullptr) return trial;
    auto& row = trial.wrenches.emplace_back();
    int at = 0;
    for (const Vec3& v :
         {given.passive.force, given.passive.torque, given.active.force, given.active.torque}) {
      for (const double number : v) row[static_cast<std::size_t>(at++)] = number;
    }
  }
  return trial;
}

/// Returns the longest call, if it was so long in both trials: the host may hold up either.
double Longest(const Trial& a, const Trial& b) {
  double longest = 0.0;
  for (std::size_t i = 0; i < a.took_s.size(); ++i) {
    longest = std::max(longest, std::min(a.took_s[i], b.took_s[i]));
  }
  return longest;
}

bool SameBits(const Trial& a, const Trial& b) {
  return std::memcmp(a.wrenches.data(), b.wrenches.data(),
                     a.wrenches.size() * sizeof a.wrenches[0]) == 0;
}

using Tell = std::function<void(const std::string&)>;

void TellFailure(const char* why, const Tell& tell) {
  tell(std::string("F") + why + "; fix it, or its parameters");
}

// Tell the effect's defects, as far as they get: faults begin with F, limits with L.

void JudgeCalls(const Effect& effect, const Vec3& centre, double radius, const Tell& tell) {
  const Effects effects({effect});
  const Trial first = Try(effects, centre, radius);
  if (first.failure != nullptr) return TellFailure(first.failure, tell);
  // In another second, so that no clock says the same.
  for (const std::time_t began = std::time(nullptr); std::time(nullptr) == began;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const Trial second = Try(effects, centre, radius);
  if (second.failure != nullptr || !SameBits(first, second)) {
    return tell(
        "Fstep gave another wrench for the same arguments and state, so no recording can be "
        "verified; use no clock, random number or variable that outlives a call, but "
        "`cycle` and `state`");
  }
  const double longest_s = Longest(first, second);
  char time[96];
  std::snprintf(time, sizeof time,
                "step takes %.0f us of the loop's millisecond, which should be "
                "at most %.0f; ",
                1e6 * longest_s, 1e6 * kSlow_s);
  const std::string slow = time + std::string("let it wait for nothing, and compute less");
  if (longest_s > kTooSlow_s) return tell("F" + slow);
  if (longest_s > kSlow_s) tell("L" + slow);
}

void JudgeEnergy(const Effect& effect, const Vec3& centre, double radius, const Tell& tell) {
  const ForeignCall call(kStep);
  const double given = EnergyGiven(effect, centre, radius);
  if (given <= kNoEnergy) return;
  if (!std::isfinite(given)) {
    return TellFailure("step failed somewhere about the objects", tell);
  }
  char share[32];
  std::snprintf(share, sizeof share, "%.2g", given);
  tell(std::string("Fclaims to be passive, but gives the hand ") + share +
       " of the energy exchanged along a closed path; fix it, or omit .passive");
}

}  // namespace

Verdict JudgeEffects(const Scene& scene) {
  Verdict verdict;
  Eigen::AlignedBox3d box;
  for (const Body& body : scene.objects) {
    for (const Vec3& v : body.mesh.vertices) box.extend(body.X_WB * v);
  }
  for (const Effect& effect : scene.effects) {
    if (effect.of == nullptr) continue;
    const std::string who = "effect " + effect.file + ": ";
    // One that hangs mostly does so at once: the first part needs no long patience.
    const auto passes = [&](auto judge, double patience_s) {
      const ForkedEnd end = RunForked(
          [&](const Tell& tell) { judge(effect, box.center(), 0.5 * box.diagonal().norm(), tell); },
          patience_s);
      const std::size_t before = verdict.faults.size();
      for (const std::string& line : end.lines) {
        (line[0] == 'F' ? verdict.faults : verdict.limits).push_back(who + line.substr(1));
      }
      if (!end.finished) {
        verdict.faults.push_back(who + end.how + "; fix it: in a server it would end all sessions");
      }
      return verdict.faults.size() == before;
    };
    if (passes(JudgeCalls, kPatience_s) && effect.of->passive != 0) {
      passes(JudgeEnergy, kLongPatience_s);
    }
  }
  return verdict;
}

}  // namespace palpate
