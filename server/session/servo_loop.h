#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include "common/dds/wire.h"
#include "common/realtime/histogram.h"
#include "common/realtime/latest_mailbox.h"
#include "common/realtime/ring.h"
#include "server/physics/haptic_step.h"
#include "server/session/cut_block.h"

namespace palpate {

/// The second button: while it is down a bur stands still.  (The first may enable forces.)
inline constexpr std::uint32_t kStopBur = 1u << 1;

/// What the loop counts between two reports; faults of poses and of steps alike.
struct LoopCounters {
  Histogram step;  ///< take to write [ns]
  std::uint64_t poses = 0;
  std::uint64_t steps = 0;
  std::uint64_t late = 0;  ///< came more than 2 ms after the one before
  std::uint64_t lost = 0;  ///< gaps in the sequence
  std::uint64_t rejected_nonfinite = 0;
  std::uint64_t rejected_sequence = 0;
  std::uint64_t rejected_speed = 0;
  std::uint64_t renormalised = 0;
  std::uint64_t faulted_steps = 0;
  std::uint32_t faults = kFaultNone;  ///< every bit seen
};

/// Where an object pushes the tool.
struct ContactForce {
  Vec3 point = Vec3::Zero();  ///< on the graphic tool, in W [m]
  Vec3 force = Vec3::Zero();  ///< on the tool, in W [N]
};

/// What the loop last did, for viewers and for the session's start.
struct LoopSnapshot {
  std::uint64_t pose_sequence = 0;
  Pose X_WH;
  Pose X_WG;
  Wrench wrench;  ///< as sent: on the hand, at the tool's centroid, in W
  std::uint32_t contacts = 0;
  std::uint32_t faults = kFaultNone;
  bool has_pose = false;  ///< false until a pose was fit to be used
  double step_s = 0.0;    ///< from take on, but for this snapshot's own copy
  /// The contacts that StepReport lists, with the part of their forces that is sent; none while the
  /// tool is held.
  int points = 0;
  std::array<ContactForce, std::tuple_size_v<decltype(StepReport::active)>> point;
};

/// The servo loop of one session: turns each pose into a wrench, on the pose's arrival.
///
/// A pose is used where it is finite and within 100 m, its quaternion has a length, its sequence
/// and time grow, and the hand did not move faster than 5 m/s or 100 rad/s since the last one used.
/// A pose that repeats or comes late gets no answer.  Any other that is not used holds the graphic
/// tool, and the force fades by a twentieth with each.  What looks like a jump is believed once
/// five samples in a row agree on it, so that a hand which really is elsewhere is followed; the
/// force then starts from zero.  The way back to full force takes 200 samples.  Samples count, not
/// clocks: equal inputs give equal bits.
///
/// Thread contract: OnPose in the servo thread; all else in one other thread (the service thread).
class ServoLoop {
 public:
  /// Allocates what the steps need.
  explicit ServoLoop(const HapticModel& model);

  /// Answers a pose.  False where there is nothing to send.
  /// Real-time: no allocation, lock, log; the clock only feeds the statistics.
  bool OnPose(const wire::HapticPose& pose, wire::Wrench& answer) noexcept;

  /// Puts the graphic tool there and lets forces begin, with the next pose.
  void Start(const Pose& X_WG) { start_.Write(X_WG); }
  /// The pose that Start was taken with: the first whose wrench the physics computed.  0 before.
  std::uint64_t start_sequence() const { return start_sequence_.load(std::memory_order_acquire); }
  /// Makes the scene whole again before the next pose's step.  What had gone may now be where the
  /// tool is, so there are no forces from that pose on, until a Start that is called once
  /// made_whole().
  void MakeWhole();
  /// The loop has done what the last MakeWhole said, or there was none.
  bool made_whole() const {
    return period_.load(std::memory_order_acquire) == newest_.load(std::memory_order_relaxed);
  }
  /// No block was given since the last MakeWhole; this loop's bur changes none, as long as no Start
  /// is called.
  bool was_given_nothing() const { return !was_given_; }
  /// Before which pose the loop has made the scene whole, each time.
  bool TakeWhole(std::uint64_t& pose_sequence) { return wholes_.Pop(pose_sequence); }
  /// The next block that the loop's bur changed, or which it had changed before the last MakeWhole:
  /// then is_current says no.  A block comes again as long as it changes, and some milliseconds
  /// late: what comes last is how it stands.  Which come, and in what order, follows from the poses
  /// and from CutBlock::held_from alone.
  bool TakeCut(CutBlock& block) { return cut_blocks_ && cut_blocks_->Pop(block); }
  bool is_current(const CutBlock& block) const {
    return block.period == newest_.load(std::memory_order_relaxed);
  }
  /// For a replay: whether the loop is to find no room for such blocks.
  void HoldCuts(bool hold) { cuts_held_ = hold; }
  /// Once no pose can come, and where blocks wait for room then: since which pose.  Else 0.
  std::uint64_t held_from() const { return held_from_; }
  /// Gives the loop a block that another's bur has changed, where it wants_cuts(): it merges a few
  /// before each pose.  The block's period is left to the loop.
  void GiveCut(CutBlock& block);
  bool wants_cuts() const { return given_ && !given_->full(); }
  /// It has merged all that it was given.
  bool has_merged() const { return !given_ || given_->size() == 0; }
  /// What the loop began to merge since.  With the poses, the starts, the wholes and the blocks the
  /// same bits follow.
  bool TakeMerge(CutMerge& merge) { return merges_ && merges_->Pop(merge); }
  /// Before the first pose, or once no more can come: what burs took away of each solid.
  std::vector<CutField>& cuts() { return state_.cuts; }
  /// Once no pose can come: the last, and how many were answered.
  std::uint64_t last_sequence() const { return last_sequence_; }
  std::uint32_t answers() const { return answers_; }
  /// The latest step, where one was made since the last call.
  bool ReadSnapshot(LoopSnapshot& snapshot) { return snapshots_.Read(snapshot); }
  /// Poses heard that were not mere repeats: stands still where the station is silent.
  std::uint64_t heard() const { return heard_.load(std::memory_order_relaxed); }
  /// Asks for the counters since the last report; they come with the next pose.
  void RequestCounters() { counters_wanted_.store(true, std::memory_order_relaxed); }
  bool ReadCounters(LoopCounters& counters) { return reports_.Read(counters); }

 private:
  bool InSequence(const wire::HapticPose& pose) noexcept;
  /// Sets X_WH_ where the pose can be used; else returns the fault.
  std::uint32_t UsePose(const wire::HapticPose& pose) noexcept;
  void BecomeWhole(std::uint64_t pose_sequence) noexcept;
  void Step(wire::Wrench& answer) noexcept;
  void TellCuts(std::uint64_t pose_sequence) noexcept;
  void MergeCuts(std::uint64_t pose_sequence, std::size_t given) noexcept;
  void Hold(std::uint32_t fault, wire::Wrench& answer) noexcept;
  void Report(wire::Wrench& answer, std::int64_t taken_ns) noexcept;

  const HapticModel& model_;
  StepWorkspace workspace_;
  StepState state_;
  bool started_ = false;
  double gain_ = 0.0;  // 0 to 1: the part of the wrench that is sent
  Wrench full_;        // the last step's wrench, unscaled
  EffectWrenches effects_;
  LoopSnapshot snapshot_;

  std::uint32_t answers_ = 0;
  bool heard_any_ = false;
  std::uint64_t last_sequence_ = 0;
  std::int64_t last_time_ns_ = 0;

  // The last pose used, and the jump that is being considered.
  bool has_pose_ = false;
  Pose X_WH_;
  std::int64_t X_WH_time_ns_ = 0;
  Pose X_WJ_;
  std::int64_t X_WJ_time_ns_ = 0;
  int jump_agreed_ = 0;

  std::int64_t last_taken_ns_ = 0;
  LoopCounters counters_;
  std::atomic<std::uint64_t> heard_{0};
  std::atomic<bool> counters_wanted_{false};
  std::atomic<std::uint64_t> start_sequence_{0};
  LatestMailbox<Pose> start_;
  LatestMailbox<LoopSnapshot> snapshots_;
  LatestMailbox<LoopCounters> reports_;
  // Null where there is nothing to cut.
  std::unique_ptr<Ring<CutBlock, 256>> cut_blocks_;  // loop -> service thread
  std::unique_ptr<Ring<CutBlock, 64>> given_;        // service thread -> loop
  std::unique_ptr<Ring<CutMerge, 64>> merges_;       // loop -> service thread
  std::uint64_t held_from_ = 0;
  std::size_t merging_ = 0;  // of given_: what the last CutMerge has said, and is not merged
  bool cuts_held_ = false;
  bool was_given_ = false;  // the service thread's: any block, since the last MakeWhole
  std::atomic<std::uint32_t> newest_{0};  // how often MakeWhole was called
  std::atomic<std::uint32_t> period_{0};  // the one of these that the loop has come to
  Ring<std::uint64_t, 16> wholes_;        // loop -> service thread
};

}  // namespace palpate
