#include "tests/support/contact_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <spdlog/fmt/fmt.h>

#include "common/math/rotation.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/physics/tree/sphere_tree_query.h"
#include "tests/support/mesh_oracle.h"

namespace palpate::test {
namespace {

constexpr int kConvergeSteps = 200;
constexpr double kConverged = 1e-8;  // [m] a step
constexpr int kSettleSteps = 2000;
constexpr double kSettled = 1e-9;  // [m] a step
constexpr int kCycleFrom = 1000;   // motion after a second counts as a cycle
constexpr int kQuarters = 4;
constexpr double kNoForce = 1e-3;  // [N]

/// Measures how far points of the tool move.
class ShapeMotion {
 public:
  ShapeMotion(const Scene& scene, const HapticModel& model) : centroid_(model.reference()) {
    for (const Vec3& v : scene.tools.front().mesh.vertices) {
      lever_ = std::max(lever_, (v - centroid_).norm());
    }
    // The rotation of a ball does not count.
    if (model.is_ball()) lever_ = 0.0;
  }
  Vec3 Centroid(const Pose& X) const { return X * centroid_; }
  /// An upper bound for all points of the mesh.
  double Between(const Pose& a, const Pose& b) const {
    return (Centroid(a) - Centroid(b)).norm() + lever_ * RotationLog(a.q * b.q.conjugate()).norm();
  }

 private:
  Vec3 centroid_;
  double lever_ = 0.0;
};

bool Due(std::size_t i, int every) {
  return every > 0 && i % static_cast<std::size_t>(every) == 0;
}

bool IsFar(const StepReport& report) {
  return (report.faults & kFaultTargetFar) != 0;
}

struct Converged {
  StepReport report;
  bool converged = false;
};
/// The state, with the objects that move held where they are.
StepState Held(StepState state) {
  state.moved = -1;
  return state;
}

Converged Converge(const ContactPath& path, const ShapeMotion& motion, const Pose& X_WH,
                   StepState state) {
  Converged answer;
  for (int i = 0; i < kConvergeSteps && !answer.converged; ++i) {
    const Pose before = state.X_WG;
    answer.report = HapticStep(path.model, X_WH, state, path.workspace);
    answer.converged = motion.Between(before, state.X_WG) < kConverged && !IsFar(answer.report);
  }
  return answer;
}

void Settle(const ContactPath& path, const ShapeMotion& motion, std::size_t step, StepState state,
            ContactFigures::Settling& settling) {
  const Pose& X_WH = path.X_WH[step];
  int moved_last = -1, same = 0;
  Pose at_second;
  Vec3 force_at_second = Vec3::Zero();
  double cycle_m = 0.0, cycle_N = 0.0;
  bool far = false;
  // The step is a function of its state, so a state that has repeated the same bits a hundred times
  // (friction counts to twenty) stays there.
  for (int i = 0; i < kSettleSteps && same < 100; ++i) {
    const Pose before = state.X_WG;
    const StepReport report = HapticStep(path.model, X_WH, state, path.workspace);
    const double moved = motion.Between(before, state.X_WG);
    far = IsFar(report);
    if (moved > kSettled || far) moved_last = i;
    same = before.p == state.X_WG.p && before.q.coeffs() == state.X_WG.q.coeffs() ? same + 1 : 0;
    if (i == kCycleFrom) {
      at_second = state.X_WG;
      force_at_second = report.wrench.force;
    } else if (i > kCycleFrom) {
      cycle_m = std::max(cycle_m, motion.Between(at_second, state.X_WG));
      cycle_N = std::max(cycle_N, (report.wrench.force - force_at_second).norm());
    }
  }
  if (far) moved_last = kSettleSteps;  // at rest, and not there
  ++settling.poses;
  settling.within_10ms += moved_last < 10;
  settling.within_50ms += moved_last < 50;
  if (moved_last <= kCycleFrom) return;
  ++settling.never;
  settling.cycle_N = std::max(settling.cycle_N, cycle_N);
  if (cycle_m > settling.cycle_m) {
    settling.cycle_m = cycle_m;
    settling.worst_step = step;
  }
}

/// Holds the hand at steps that did not arrive: at each one, or if there are too many at every
/// second, fourth and so on, so that the tried steps are evenly spread.
class Holder {
 public:
  void Add(const ContactPath& path, std::size_t step, const StepState& state, const Vec3& force) {
    if (seen_++ % every_ != 0) return;
    tries_.push_back(Try(path, step, state, force));
    if (tries_.size() <= ContactFigures::kMostHeld) return;
    for (std::size_t i = 0; 2 * i < tries_.size(); ++i) tries_[i] = tries_[2 * i];
    tries_.resize((tries_.size() + 1) / 2);
    every_ *= 2;
  }
  ContactFigures::Held Figures() const {
    ContactFigures::Held held;
    held.tried = tries_.size();
    for (const Outcome& tried : tries_) {
      if (tried.arrived) {
        held.steps_needed.push_back(tried.steps);
        held.force_error.push_back(tried.force_error);
        continue;
      }
      if (held.never++ == 0) held.first_step = tried.step;
      held.without_force += tried.without_force;
      held.stuck += tried.without_force && tried.standing;
    }
    std::ranges::sort(held.steps_needed);
    std::ranges::sort(held.force_error);
    return held;
  }

 private:
  struct Outcome {
    std::size_t step;
    int steps = 0;
    double force_error = 0.0;
    bool arrived = false, without_force = false, standing = false;
  };
  static Outcome Try(const ContactPath& path, std::size_t step, StepState state,
                     const Vec3& force) {
    Outcome tried{.step = step};
    while (!tried.arrived && tried.steps < ContactFigures::kHeldSteps) {
      const Pose before = state.X_WG;
      const StepReport report = HapticStep(path.model, path.X_WH[step], state, path.workspace);
      ++tried.steps;
      tried.arrived = !IsFar(report);
      tried.without_force = report.wrench.force.norm() < kNoForce;
      tried.force_error = (report.wrench.force - force).norm();
      tried.standing = before.p == state.X_WG.p && before.q.coeffs() == state.X_WG.q.coeffs();
    }
    return tried;
  }

  std::vector<Outcome> tries_;
  std::size_t seen_ = 0, every_ = 1;
};

/// The hand between two of its samples.
Pose Between(const Pose& a, const Pose& b, double share) {
  const Vec3 turn = RotationLog(b.q * a.q.conjugate());
  return {(1.0 - share) * a.p + share * b.p, RotationExp(share * turn) * a.q};
}

void CompareQuarters(const ContactPath& path, std::span<const Vec3> force,
                     const ContactChecks& checks, ContactFigures& figures) {
  StepState state = path.start;
  double difference2 = 0.0, force2 = 0.0;
  for (std::size_t i = 0; i < path.X_WH.size(); ++i) {
    if (checks.progress && i % 500 == 0) {
      checks.progress("at 4 kHz", static_cast<double>(i) / static_cast<double>(path.X_WH.size()));
    }
    for (int k = 1; i > 0 && k < kQuarters; ++k) {
      HapticStep(path.model,
                 Between(path.X_WH[i - 1], path.X_WH[i], static_cast<double>(k) / kQuarters), state,
                 path.workspace);
    }
    const StepReport report = HapticStep(path.model, path.X_WH[i], state, path.workspace);
    difference2 += (report.wrench.force - force[i]).squaredNorm();
    force2 += force[i].squaredNorm();
  }
  figures.force_4khz_rms_fraction = force2 > 0.0        ? std::sqrt(difference2 / force2)
                                    : difference2 > 0.0 ? INFINITY
                                                        : 0.0;
}

double Share(std::size_t part, std::size_t of) {
  return of == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(of);
}

}  // namespace

double ContactFigures::meeting_fraction() const {
  return Share(meeting, depth.size());
}

double ContactFigures::arrived_fraction() const {
  return Share(arrived, steps);
}

ContactFigures MeasureContact(const ContactPath& path, const ContactChecks& checks,
                              std::vector<StepReport>* reports) {
  ContactFigures figures;
  figures.steps = path.X_WH.size();
  MeshOracle oracle(path.scene);
  const ShapeMotion motion(path.scene, path.model);
  const JumpJudge judge(path.scene, path.model);
  StepState state = path.start;
  StepReport before;
  std::vector<Vec3> force;
  std::vector<double> by_hand;
  Holder holder;
  SupportMeasure support(path.scene, path.model, path.workspace);
  double deepest = 0.0, force2 = 0.0;
  std::size_t behind = 0;
  for (std::size_t i = 0; i < figures.steps; ++i) {
    if (checks.progress && i % 100 == 0) checks.progress("checking", Share(i, figures.steps));
    const Pose& X_WH = path.X_WH[i];
    const StepReport report = HapticStep(path.model, X_WH, state, path.workspace);
    const Wrench& wrench = report.wrench;
    figures.finite &= report.X_WG.p.allFinite() && report.X_WG.q.coeffs().allFinite() &&
                      wrench.force.allFinite() && wrench.torque.allFinite();
    force.push_back(wrench.force);
    force2 += wrench.force.squaredNorm();
    const bool far = IsFar(report);
    figures.arrived += !far;
    behind = far ? behind + 1 : 0;
    figures.longest_behind = std::max(figures.longest_behind, behind);
    by_hand.push_back(i > 0 ? judge.ByHand(path.X_WH[i - 1], before, X_WH, report) : 0.0);
    if (i > 0) {
      const Pose& X_WH_before = path.X_WH[i - 1];
      figures.mean_speed += (motion.Centroid(X_WH) - motion.Centroid(X_WH_before)).norm();
      ContactFigures::Jumps& jumps = figures.jumps;
      const double jump = (wrench.force - before.wrench.force).norm();
      jumps.torque_max = std::max(jumps.torque_max, (wrench.torque - before.wrench.torque).norm());
      const JumpCause judged = judge.Judge(X_WH_before, before, X_WH, report);
      const auto cause = static_cast<std::size_t>(judged);
      ++jumps.count[cause];
      const std::uint32_t faults = report.faults | before.faults;
      jumps.behind +=
          cause > static_cast<std::size_t>(JumpCause::kHand) && (faults & kFaultTargetFar) != 0;
      if (jump > jumps.force[cause]) {
        jumps.force[cause] = jump;
        jumps.step[cause] = i;
      }
    }
    if (Due(i, checks.oracle_every)) {
      std::vector<Pose> moved;
      for (std::size_t k = 0; k < path.scene.moved.size(); ++k) {
        moved.push_back(state.frames[k + 1].X_WB);
      }
      oracle.Move(moved);
      const MeshOracle::Overlap overlap = oracle.At(report.X_WG);
      figures.depth.push_back(overlap.depth);
      figures.meeting += overlap.meet;
      if (overlap.depth > deepest) {
        deepest = overlap.depth;
        figures.deepest_step = i;
      }
    }
    if (Due(i, checks.converge_every)) {
      const Converged truth = Converge(path, motion, X_WH, Held(state));
      figures.unconverged += !truth.converged;
      figures.force_error.push_back((wrench.force - truth.report.wrench.force).norm());
      if (!far) figures.arrived_error.push_back(figures.force_error.back());
      if (far) {
        figures.lag.push_back(
            (motion.Centroid(report.X_WG) - motion.Centroid(truth.report.X_WG)).norm());
      }
    }
    support.Count(report);
    if (Due(i, checks.judge_every)) support.Judge(i, X_WH, report, state);
    if (checks.hold_far && far) holder.Add(path, i, Held(state), wrench.force);
    if (Due(i, checks.settle_every)) Settle(path, motion, i, Held(state), figures.settling);
    if (reports != nullptr) reports->push_back(report);
    before = report;
  }
  figures.mean_speed /= 1e-3 * static_cast<double>(std::max<std::size_t>(2, figures.steps) - 1);
  figures.force_rms =
      std::sqrt(force2 / static_cast<double>(std::max<std::size_t>(1, figures.steps)));
  figures.force = JudgeForce(force, by_hand);
  figures.held = holder.Figures();
  figures.support = support.figures();
  if (checks.quarter_steps) CompareQuarters(path, force, checks, figures);
  return figures;
}

ContactFigures MeasureContact(const Scene& scene, std::span<const Pose> X_WH,
                              const ContactChecks& checks, std::vector<StepReport>* reports) {
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  StepState start(model);
  start.X_WG = ResolveStart(model, X_WH.front(), workspace).X_WG;
  return MeasureContact(ContactPath{scene, model, workspace, start, X_WH}, checks, reports);
}

std::string BrokenLimits(const ContactFigures& figures, const ContactLimits& limits) {
  std::string broken;
  const auto line = [&](const std::string& text) { broken += text + "\n"; };
  if (!figures.finite) line("a pose or a wrench is not finite");
  if (figures.meeting_fraction() > limits.meeting_fraction) {
    line(fmt::format("meshes meet at {} of {} poses", figures.meeting, figures.depth.size()));
  }
  const double depth =
      figures.depth.empty() ? 0.0 : *std::max_element(figures.depth.begin(), figures.depth.end());
  if (depth > limits.depth) {
    line(fmt::format("meshes are {:.3f} um deep at step {}", 1e6 * depth, figures.deepest_step));
  }
  if (figures.arrived_fraction() < limits.arrived_fraction) {
    line(fmt::format("the tool arrived in {} of {} steps", figures.arrived, figures.steps));
  }
  if (figures.held.never > limits.never_arrived) {
    line(fmt::format("held still the tool never arrives from {} steps, the first of them {}",
                     figures.held.never, figures.held.first_step));
  }
  if (figures.held.stuck > limits.stuck) {
    line(fmt::format("of those {} stand still, and the hand feels nothing", figures.held.stuck));
  }
  if (figures.force.notches.size() > limits.notches) {
    line(fmt::format("the force has {} notches, the first at step {}", figures.force.notches.size(),
                     figures.force.notches.front().begin + 1));
  }
  const ContactFigures::Jumps& jumps = figures.jumps;
  if (figures.force.largest_jump.size > limits.jump) {
    const auto worst = static_cast<std::size_t>(
        std::max_element(jumps.force.begin(), jumps.force.end()) - jumps.force.begin());
    line(fmt::format("the force jumps by {:.3f} N at step {} ({})", figures.force.largest_jump.size,
                     figures.force.largest_jump.step, NameOf(static_cast<JumpCause>(worst))));
  }
  if (jumps.unexplained() > limits.unexplained) {
    const auto at = static_cast<std::size_t>(JumpCause::kUnexplained);
    line(fmt::format("{} jumps without a cause, the greatest {:.3f} N at step {}",
                     jumps.unexplained(), jumps.force[at], jumps.step[at]));
  }
  if (figures.force_4khz_rms_fraction > limits.force_4khz) {
    line(fmt::format("force at 4 kHz is off by {:.2f} %", 1e2 * figures.force_4khz_rms_fraction));
  }
  const ContactFigures::Settling& settling = figures.settling;
  if (Share(settling.within_10ms, settling.poses) < limits.settled_10ms ||
      Share(settling.within_50ms, settling.poses) < limits.settled_50ms) {
    line(
        fmt::format("of {} poses {} settle within 10 ms and {} within 50 ms; the greatest cycle is "
                    "{:.3f} um, at step {}",
                    settling.poses, settling.within_10ms, settling.within_50ms,
                    1e6 * settling.cycle_m, settling.worst_step));
  }
  return broken;
}

}  // namespace palpate::test
