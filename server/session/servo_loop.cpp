#include "server/session/servo_loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/bur_button.h"
#include "common/math/rotation.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr double kMaxCoordinate_m = 100.0;
constexpr double kMaxSpeed_m_s = 5.0;  // above a hand's fastest strokes
constexpr double kMaxTurn_rad_s = 100.0;
constexpr int kJumpAgreement = 5;        // samples
constexpr double kUnitTolerance = 1e-6;  // of |q|^2; as far as single-precision drivers are off
constexpr double kWrenchValid_s = 0.05;
/// The distance within which the rows are said to hold: kWrenchValid_s of a hand at 0.1 m/s.  No
/// step guarantees that.  What its prediction left out lies outside the bounds of its last
/// sub-step, tenths of a millimetre, and a row is a tangent, off by d^2 / 2R at a distance d on a
/// surface of radius R.  As measured (results/closed-loop.md), the force on the bunny is
/// then 5 % off at 1 mm.
constexpr double kRegion_m = 5e-3;
constexpr std::int64_t kLate_ns = 2'000'000;
/// Most blocks of solids, 2 kB each, that a pose's answer may copy for viewers: in 15 ms all those
/// that a bur of 1.4 mm touches.  Others wait, and are told with their content of that time.
constexpr int kMostCutBlocks = 4;
/// Most blocks of other sessions that a pose may merge, some 10 us each; and while
/// there are no forces.
constexpr int kMostMerged = 2, kMostMergedAtRest = 16;

bool IsFinite(const Pose& X) noexcept {
  // A sum of finite terms may overflow, but bounded terms cannot; comparisons with NaN are false.
  return (X.p.array().abs() <= kMaxCoordinate_m).all() && (X.q.coeffs().array().abs() <= 2.0).all();
}

/// Returns whether a hand can be at A and, at a later time, at B.
bool Reachable(const Pose& A, std::int64_t A_ns, const Pose& B, std::int64_t B_ns) noexcept {
  // Unsigned, because the difference of a broken clock's times may not fit a signed number.
  const double dt = 1e-9 * static_cast<double>(static_cast<std::uint64_t>(B_ns) -
                                               static_cast<std::uint64_t>(A_ns));
  const Vec3 turn = RotationLog(B.q * A.q.conjugate());
  return (B.p - A.p).squaredNorm() <= kMaxSpeed_m_s * kMaxSpeed_m_s * dt * dt &&
         turn.squaredNorm() <= kMaxTurn_rad_s * kMaxTurn_rad_s * dt * dt;
}

void Clear(wire::Wrench& answer) noexcept {
  answer = wire::Wrench{};
  answer.valid_s = kWrenchValid_s;
}

void SetScaled(const Wrench& full, const EffectWrenches& effects, double gain,
               wire::Wrench& answer) noexcept {
  wire::FromVec3(gain * full.force, answer.force_N);
  wire::FromVec3(gain * full.torque, answer.torque_Nm);
  wire::FromVec3(gain * effects.passive.force, answer.passive_force_N);
  wire::FromVec3(gain * effects.passive.torque, answer.passive_torque_Nm);
  wire::FromVec3(gain * effects.active.force, answer.active_force_N);
  wire::FromVec3(gain * effects.active.torque, answer.active_torque_Nm);
}

}  // namespace

ServoLoop::ServoLoop(const HapticModel& model)
    : ServoLoop(std::make_shared<World>(std::vector{&model}), 0) {}

ServoLoop::ServoLoop(std::shared_ptr<World> world, std::size_t tool)
    : world_(std::move(world)), tool_(tool), hand_(world_->MakeHand()) {
  snapshot_.moved = model().moved().size();
  if (!cuts().empty()) {
    cut_blocks_ = std::make_unique<Ring<CutBlock, 256>>();
    given_ = std::make_unique<Ring<CutBlock, 64>>();
    merges_ = std::make_unique<Ring<CutMerge, 64>>();
  }
}

void ServoLoop::MakeWhole() {
  was_given_ = false;
  newest_.fetch_add(1, std::memory_order_release);
}

void ServoLoop::GiveCut(CutBlock& block) {
  block.period = newest_;
  given_->Push(block);
  was_given_ = true;
}

bool ServoLoop::OnPose(const wire::HapticPose& pose, wire::Wrench& answer) noexcept {
  const std::int64_t taken_ns = SteadyNanoseconds();
  ++counters_.poses;
  if (!InSequence(pose)) {
    ++counters_.rejected_sequence;
    return false;
  }
  heard_.fetch_add(1, std::memory_order_relaxed);
  const World::Turn turn(*world_);
  world_->Hear(tool_, hand_);
  TakeStart(pose.pose_sequence);

  // Read first, so that blocks given after a MakeWhole are seen after it.
  const std::size_t given = given_ ? given_->size() : 0;
  // After the start, because a start that was found in the cut scene is void.
  BecomeWhole(pose.pose_sequence);
  if (given > 0) MergeCuts(pose.pose_sequence, given);

  Clear(answer);
  state().cut.spins = (pose.buttons & kStillBurButton) == 0;
  snapshot_.points = 0;
  snapshot_.buttons = pose.buttons;
  answer.pose_sequence = pose.pose_sequence;
  answer.pose_time_ns = pose.sample_time_ns;
  answer.answer = ++answers_;
  if (const std::uint32_t fault = UsePose(pose); fault != kFaultNone) {
    Hold(fault, answer);
  } else if (!started_) {
    X_WG_ = X_WH_;
    answer.faults = kFaultNotStarted;
  } else {
    Step(answer);
  }
  if (started_) X_WG_ = state().X_WG;
  wire::FromPose(X_WG_, answer.graphic_position_m, answer.graphic_orientation_wxyz);
  answer.step = world_->steps();
  answer.hands = world_->there();
  if (cut_blocks_) TellCuts(pose.pose_sequence);
  Report(answer, taken_ns);
  return true;
}

void ServoLoop::BecomeWhole(std::uint64_t pose_sequence) noexcept {
  const std::uint32_t newest = newest_.load(std::memory_order_acquire);
  // What cannot be recorded is not done.
  if (newest == period_ || !wholes_.Push(pose_sequence)) return;
  for (CutField& cut : cuts()) cut.MakeWhole();
  state().RestMoved(model().moved().size());
  merging_ = 0;
  started_ = false;
  gain() = 0.0;
  // Last of all, because the service thread then takes it as done.
  period_.store(newest, std::memory_order_release);
}

void ServoLoop::Leave() noexcept {
  if (!world_->is_shared() || answers_ == 0) return;
  const World::Turn turn(*world_);
  world_->Leave(tool_, hand_);
}

void ServoLoop::LoseStart() noexcept {
  started_ = false;
  voids_.fetch_add(1, std::memory_order_release);
}

void ServoLoop::TakeStart(std::uint64_t pose_sequence) noexcept {
  if (started_ && !world_->Holds(tool_, hand_)) LoseStart();
  Pose X_WG;
  if (!start_.Read(X_WG)) return;
  if (!world_->Place(tool_, hand_, X_WG)) return LoseStart();
  started_ = true;
  start_sequence_.store(pose_sequence, std::memory_order_release);
}

bool ServoLoop::InSequence(const wire::HapticPose& pose) noexcept {
  if (heard_any_) {
    if (pose.pose_sequence <= last_sequence_ || pose.sample_time_ns <= last_time_ns_) return false;
    counters_.lost += pose.pose_sequence - last_sequence_ - 1;
  }
  heard_any_ = true;
  last_sequence_ = pose.pose_sequence;
  last_time_ns_ = pose.sample_time_ns;
  return true;
}

std::uint32_t ServoLoop::UsePose(const wire::HapticPose& pose) noexcept {
  Pose X_WH = wire::ToPose(pose);
  const double norm2 = X_WH.q.squaredNorm();
  if (!IsFinite(X_WH) || !(norm2 >= 0.25)) {
    ++counters_.rejected_nonfinite;
    return kFaultBadPose;
  }
  if (std::abs(norm2 - 1.0) > kUnitTolerance) ++counters_.renormalised;
  X_WH.q.coeffs() /= std::sqrt(norm2);

  const std::int64_t time_ns = pose.sample_time_ns;
  if (has_pose_ && !Reachable(X_WH_, X_WH_time_ns_, X_WH, time_ns)) {
    const bool agrees = jump_agreed_ > 0 && Reachable(X_WJ_, X_WJ_time_ns_, X_WH, time_ns);
    jump_agreed_ = agrees ? jump_agreed_ + 1 : 1;
    X_WJ_ = X_WH;
    X_WJ_time_ns_ = time_ns;
    // Where hands meet, the tool first lets go of the others.
    const bool is_held = started_ && world_->is_shared() && world_->Holds(tool_, hand_);
    if (jump_agreed_ < kJumpAgreement || is_held) {
      ++counters_.rejected_speed;
      return kFaultPoseRejected;
    }
    if (started_) gain() = 0.0;
  }
  jump_agreed_ = 0;
  has_pose_ = true;
  X_WH_ = X_WH;
  X_WH_time_ns_ = time_ns;
  return kFaultNone;
}

void ServoLoop::Step(wire::Wrench& answer) noexcept {
  const StepReport& report = world_->Step(tool_, X_WH_);
  ++counters_.steps;
  if (report.faults != kFaultNone) ++counters_.faulted_steps;
  const double part = gain();
  full_ = report.wrench;
  effects_ = report.effects;
  SetScaled(full_, effects_, part, answer);
  answer.faults = report.faults;
  int rigid = 0;
  while (rigid < report.contacts && std::isinf(report.active[rigid].stiffness)) ++rigid;
  answer.contacts = static_cast<std::uint32_t>(rigid + report.soft_contacts);
  for (int i = 0; i < report.contacts; ++i) {
    const ActiveRow& active = report.active[i];
    snapshot_.point[i] = {active.contact_W,
                          part * (active.force * active.normal + active.friction)};
  }
  snapshot_.points = report.contacts;
  if (!report.bur_force.isZero(0.0) && snapshot_.points < std::ssize(snapshot_.point)) {
    snapshot_.point[snapshot_.points++] = {report.bur_W, part * report.bur_force};
  }
  // A station computes the full force from the rows.  None are given while the sent force is less,
  // or while something else pushes too: soft rows, a jam's seventh row, a tool that itself gives
  // way.
  constexpr int kMost = std::size(decltype(answer.row_force_N){});
  const auto gives_way = [](const ActiveRow& row) { return row.tool >= 0; };
  if (part < 1.0 || report.soft_contacts > 0 || rigid > kMost ||
      std::any_of(report.active.begin(), report.active.begin() + rigid, gives_way)) {
    return;
  }
  answer.rows = answer.contacts;
  answer.region_m = kRegion_m;
  answer.region_rad = model().is_ball() ? std::numbers::pi
                                        : kRegion_m / std::max(model().tool().max_lever, kRegion_m);
  for (int i = 0; i < rigid; ++i) {
    const ActiveRow& active = report.active[i];
    for (int k = 0; k < 3; ++k) {
      answer.row[i][k] = active.normal[k];
      answer.row[i][3 + k] = active.lever_cross_normal[k];
    }
    answer.row_offset_m[i] = active.offset;
    answer.row_force_N[i] = active.force;
  }
}

void ServoLoop::MergeCuts(std::uint64_t pose_sequence, std::size_t given) noexcept {
  if (merging_ == 0) {
    for (; given > 0 && given_->Front().period != period_; --given) given_->Drop();
    if (given == 0) return;
    // What cannot be recorded is not done.
    const CutMerge merge{pose_sequence, given_->Front().number, static_cast<std::uint32_t>(given)};
    if (!merges_->Push(merge)) return;
    merging_ = given;
  }
  for (int i = started_ ? kMostMerged : kMostMergedAtRest; i > 0 && merging_ > 0; --i) {
    const CutBlock& block = given_->Front();
    cuts()[block.solid].Merge(block.block, block.merged());
    given_->Drop();
    --merging_;
  }
}

void ServoLoop::TellCuts(std::uint64_t pose_sequence) noexcept {
  if (std::ranges::none_of(cuts(), &CutField::has_changed)) return;
  // All or none: a replay then needs only the pose since which there was no room.
  if (cuts_held_ || cut_blocks_->size() + kMostCutBlocks > cut_blocks_->kCapacity) {
    if (held_from_ == 0) held_from_ = pose_sequence;
    return;
  }
  CutBlock published;
  for (int i = 0; i < kMostCutBlocks && TakeChanged(cuts(), published); ++i) {
    published.period = period_;
    published.pose_sequence = pose_sequence;
    published.held_from = std::exchange(held_from_, 0);
    cut_blocks_->Push(published);
  }
}

void ServoLoop::Hold(std::uint32_t fault, wire::Wrench& answer) noexcept {
  if (started_) world_->Fade(tool_);
  // Where hands meet, another may hold the tool by now: its gain is not this hand's.
  SetScaled(full_, effects_, started_ ? gain() : 0.0, answer);
  answer.faults = started_ ? fault : fault | kFaultNotStarted;
}

void ServoLoop::Report(wire::Wrench& answer, std::int64_t taken_ns) noexcept {
  snapshot_.pose_sequence = answer.pose_sequence;
  snapshot_.X_WH = X_WH_;
  snapshot_.X_WG = X_WG_;
  snapshot_.wrench = wire::ToWrench(answer);
  snapshot_.contacts = answer.contacts;
  snapshot_.faults = answer.faults;
  snapshot_.has_pose = has_pose_;
  for (std::size_t i = 0; i < snapshot_.moved; ++i) {
    snapshot_.X_moved[i] = state().frames[i + 1].X_WB;
  }
  snapshot_.step_s = 1e-9 * static_cast<double>(SteadyNanoseconds() - taken_ns);
  snapshots_.Write(snapshot_);

  counters_.faults |= answer.faults;
  if (last_taken_ns_ != 0 && taken_ns - last_taken_ns_ > kLate_ns) ++counters_.late;
  last_taken_ns_ = taken_ns;
  const std::int64_t step_ns = SteadyNanoseconds() - taken_ns;
  answer.step_time_s = 1e-9 * static_cast<double>(step_ns);
  counters_.step.Add(step_ns);
  if (counters_wanted_.load(std::memory_order_relaxed)) {
    counters_wanted_.store(false, std::memory_order_relaxed);
    reports_.Write(counters_);
    counters_ = LoopCounters{};
  }
}

}  // namespace palpate
