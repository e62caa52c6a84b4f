#include "tests/benchmarks/delayed_slide.h"

#include <algorithm>
#include <cmath>

#include "client/station/local_contact_model.h"
#include "server/session/servo_loop.h"

namespace palpate::bench {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kContact_N = 0.5;
/// Until the servo loop has let the whole force in, and blends are over.
constexpr int kLead = 300;

SlideError ErrorOf(std::vector<double> errors) {
  SlideError error;
  if (errors.empty()) return error;
  std::sort(errors.begin(), errors.end());
  for (const double each : errors) error.mean += each / static_cast<double>(errors.size());
  error.p99 = errors[(errors.size() - 1) * 99 / 100];
  error.max = errors.back();
  return error;
}

}  // namespace

std::vector<Pose> AtSpeed(const std::vector<Pose>& way, double speed_m_s) {
  const double stride = 1e-3 * speed_m_s;
  std::vector<Pose> poses{way.front()};
  double left = stride;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Pose &A = way[i - 1], &B = way[i];
    const double length = (B.p - A.p).norm();
    double done = 0.0;
    while (length - done >= left) {
      done += left;
      left = stride;
      poses.push_back({A.p + (done / length) * (B.p - A.p), A.q.slerp(done / length, B.q)});
    }
    left -= length - done;
  }
  return poses;
}

SlideErrors MeasureDelayedSlide(const HapticModel& model, const std::vector<Pose>& hand,
                                const DelayedSlide& slide) {
  ServoLoop loop(model);
  StepWorkspace workspace(model);
  loop.Start(ResolveStart(model, hand.front(), workspace).X_WG);
  const int count = static_cast<int>(hand.size()) + kLead;
  const auto pose_at = [&](int i) {
    return hand[static_cast<std::size_t>(std::max(i - kLead, 0))];
  };
  std::vector<Reply> replies;
  for (int i = 0; i < count; ++i) {
    wire::HapticPose pose{};
    pose.pose_sequence = static_cast<std::uint64_t>(i) + 1;
    pose.sample_time_ns = kTick_ns * (i + 1);
    wire::FromPose(pose_at(i), pose.position_m, pose.orientation_wxyz);
    wire::Wrench answer{};
    loop.OnPose(pose, answer);
    replies.push_back(ToReply(answer, pose.sample_time_ns + kTick_ns * slide.delay_ms));
  }

  LocalContactModel local;
  local.SetSpring(
      {model.parameters().stiffness, model.parameters().torsional_stiffness, model.reference()});
  SlideErrors errors;
  std::vector<double> late_errors, local_errors;
  for (int i = slide.delay_ms; i < count; ++i) {
    const Reply& newest = replies[static_cast<std::size_t>(i - slide.delay_ms)];
    const Pose answered = pose_at(i - slide.delay_ms);
    local.Take(newest, answered);
    const LocalContactModel::Evaluation felt = local.At(kTick_ns * (i + 1), pose_at(i));
    if (i < kLead + slide.delay_ms) continue;
    const Vec3 now = replies[static_cast<std::size_t>(i)].wrench.force;
    const double force = now.norm();
    if (force < kContact_N) continue;
    ++errors.ticks;
    errors.mean_force_N += force;
    errors.beyond_region += felt.beyond_region;
    late_errors.push_back((newest.wrench.force - now).norm() / force);
    local_errors.push_back((felt.wrench.force - now).norm() / force);
  }
  if (errors.ticks > 0) {
    errors.mean_force_N /= static_cast<double>(errors.ticks);
    errors.beyond_region /= static_cast<double>(errors.ticks);
  }
  errors.late = ErrorOf(std::move(late_errors));
  errors.local = ErrorOf(std::move(local_errors));
  return errors;
}

}  // namespace palpate::bench
