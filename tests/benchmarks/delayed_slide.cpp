#include "tests/benchmarks/delayed_slide.h"

#include <algorithm>
#include <cmath>

#include "client/station/local_contact_model.h"
#include "client/station/pose_lead.h"
#include "common/error.h"
#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kContact_N = 0.5;
/// Time until the servo loop has ramped in the whole force, and blends have ended.
constexpr std::size_t kRest = 300;

/// Returns a server's answers to these poses, one per millisecond.
std::vector<Reply> Answers(const HapticModel& model, const std::vector<Pose>& poses, int delay_ms) {
  ServoLoop loop(model);
  StepWorkspace workspace(model);
  loop.Start(ResolveStart(model, poses.front(), workspace).X_WG);
  std::vector<Reply> replies;
  for (const Pose& X_WH : poses) {
    wire::HapticPose pose{};
    pose.pose_sequence = replies.size() + 1;
    pose.sample_time_ns = kTick_ns * static_cast<std::int64_t>(pose.pose_sequence);
    wire::FromPose(X_WH, pose.position_m, pose.orientation_wxyz);
    wire::Wrench answer{};
    loop.OnPose(pose, answer);
    replies.push_back(ToReply(answer, pose.sample_time_ns + kTick_ns * delay_ms));
  }
  return replies;
}

SlideError ErrorOf(std::vector<double> errors) {
  SlideError error;
  if (errors.empty()) return error;
  std::sort(errors.begin(), errors.end());
  for (const double each : errors) error.mean += each / static_cast<double>(errors.size());
  error.p50 = errors[(errors.size() - 1) / 2];
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

SlideTicks MeasureDelayedSlide(const HapticModel& model, const std::vector<Pose>& hand,
                               const DelayedSlide& slide) {
  std::vector<Pose> poses(kRest, hand.front());  // at rest first
  poses.insert(poses.end(), hand.begin(), hand.end());
  // The poses as StationCore sends them.
  PoseLead lead;
  std::vector<Pose> sent;
  for (const Pose& X_WH : poses) {
    sent.push_back(lead.Lead(kTick_ns * static_cast<std::int64_t>(sent.size() + 1), X_WH));
    lead.Hear(1e-3 * slide.delay_ms);
  }
  const std::vector<Reply> right = Answers(model, poses, slide.delay_ms);
  const std::vector<Reply> answers = Answers(model, sent, slide.delay_ms);

  LocalContactModel local;
  local.SetSpring(
      {model.parameters().stiffness, model.parameters().torsional_stiffness, model.reference()});
  SlideTicks ticks;
  const auto delay = static_cast<std::size_t>(slide.delay_ms);
  for (std::size_t i = delay; i < poses.size(); ++i) {
    local.Take(answers[i - delay], sent[i - delay]);
    const LocalContactModel::Evaluation felt =
        local.At(kTick_ns * static_cast<std::int64_t>(i + 1), poses[i]);
    if (i < kRest + delay) continue;
    ++ticks.sought;
    const Vec3 now = right[i].wrench.force;
    const double force = now.norm();
    if (force < kContact_N) continue;
    ticks.force_N += force;
    ticks.beyond_region += felt.beyond_region;
    ticks.late.push_back((right[i - delay].wrench.force - now).norm() / force);
    ticks.local.push_back((felt.wrench.force - now).norm() / force);
  }
  return ticks;
}

SlideErrors ErrorsOf(std::span<const SlideTicks> slides) {
  SlideErrors errors;
  SlideTicks all;
  for (const SlideTicks& slide : slides) {
    all.late.insert(all.late.end(), slide.late.begin(), slide.late.end());
    all.local.insert(all.local.end(), slide.local.begin(), slide.local.end());
    all.force_N += slide.force_N;
    all.beyond_region += slide.beyond_region;
    all.sought += slide.sought;
  }
  errors.ticks = all.late.size();
  if (errors.ticks == 0) return errors;
  const auto count = static_cast<double>(errors.ticks);
  errors.mean_force_N = all.force_N / count;
  errors.contact = count / static_cast<double>(all.sought);
  errors.beyond_region = static_cast<double>(all.beyond_region) / count;
  errors.late = ErrorOf(std::move(all.late));
  errors.local = ErrorOf(std::move(all.local));
  return errors;
}

namespace {

/// Makes a slide with the physics itself: each pose of the hand is the graphic tool's last pose,
/// moved by a stride along the surface and pressed in along the force's normal.
SlidePath SeededPath(const HapticModel& model, std::uint64_t seed, double length_m) {
  constexpr double kFrom_m = 0.25;        // further than two bunnies reach
  constexpr double kStride_m = 1e-4;      // a millisecond at 0.1 m/s
  constexpr double kCome_m = 5e-4;        // ... of the way there, at 0.5 m/s
  constexpr double kSmooth = 1.0 / 30.0;  // of the normal, per stride: over 3 mm
  test::Random random(seed);
  const Quat q = random.Rotation();
  const Vec3 side = random.Direction();
  const Vec3 aim = random.InCube(0.02);
  Vec3 along = random.Direction();
  const double stiffness = model.parameters().stiffness;
  const Vec3 arm = q * model.reference();

  StepWorkspace workspace(model);
  StepState state(model);
  Vec3 normal = side;
  Vec3 hand = aim + kFrom_m * side;  // of the tool's reference point
  state.X_WG = state.X_WH = {hand - arm, q};
  SlidePath path{"seed " + std::to_string(seed), {}};
  const auto come = static_cast<int>(kFrom_m / kCome_m);
  const auto strides = static_cast<std::size_t>(length_m / kStride_m);
  double depth = 0.0;
  for (int i = 0; path.hand.size() < strides; ++i) {
    if (i > come + 10 * static_cast<int>(strides)) {
      throw Error("closed-loop: " + path.name + " finds no contact");
    }
    const Pose X_WH{hand - arm, q};
    const StepReport report = HapticStep(model, X_WH, state, workspace);
    const double force = report.wrench.force.norm();
    if (force == 0.0 && path.hand.empty()) {
      hand -= kCome_m * side;
      continue;
    }
    if (force > 0.0)
      normal = (normal + kSmooth * (report.wrench.force / force - normal)).normalized();
    along = (along - along.dot(normal) * normal).normalized();
    // Presses in, or approaches the surface again if contact was lost, one stride at a time.
    depth = std::min(force / stiffness + kStride_m, kSlideDepth_m);
    hand = report.X_WG * model.reference() + kStride_m * along - depth * normal;
    path.hand.push_back({hand - arm, q});
  }
  return path;
}

}  // namespace

std::vector<SlidePath> SlidePaths(const HapticModel& model, int seeded, std::uint64_t seed,
                                  double length_m) {
  const PoseScript script = PoseScript::Load(ScriptFileBeside("bunny-bunny"));
  std::vector<SlidePath> paths{{"script", {}}};
  for (double t = 1.1; t < 3.8; t += 1e-3) paths.front().hand.push_back(script.At(t));
  for (int i = 0; i < seeded; ++i) {
    paths.push_back(SeededPath(model, seed + static_cast<std::uint64_t>(i), length_m));
  }
  return paths;
}

}  // namespace palpate::bench
