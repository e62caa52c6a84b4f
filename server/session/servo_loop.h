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
#include "server/session/world.h"

namespace palpate {

/// Counters of the loop between two reports, for faults of poses and of steps.
struct LoopCounters {
  Histogram step;  ///< from taking a pose to writing the answer [ns]
  std::uint64_t poses = 0;
  std::uint64_t steps = 0;
  std::uint64_t late = 0;  ///< poses more than 2 ms after the one before
  std::uint64_t lost = 0;  ///< gaps in the sequence
  std::uint64_t rejected_nonfinite = 0;
  std::uint64_t rejected_sequence = 0;
  std::uint64_t rejected_speed = 0;
  std::uint64_t renormalised = 0;
  std::uint64_t faulted_steps = 0;
  std::uint32_t faults = kFaultNone;  ///< union of all fault bits
};

/// A force with which an object pushes the tool.
struct ContactForce {
  Vec3 point = Vec3::Zero();  ///< on the graphic tool, in W [m]
  Vec3 force = Vec3::Zero();  ///< on the tool, in W [N]
};

/// The latest step of the loop, for viewers and for the session's start.
struct LoopSnapshot {
  std::uint64_t pose_sequence = 0;
  Pose X_WH;
  Pose X_WG;
  Wrench wrench;  ///< as sent: on the hand, at the tool's centroid, in W
  std::uint32_t contacts = 0;
  std::uint32_t faults = kFaultNone;
  std::uint32_t buttons = 0;
  bool has_pose = false;  ///< false until the first usable pose
  double step_s = 0.0;    ///< from taking the pose, without the copying of this snapshot
  /// The contacts that StepReport lists, each with the part of its force that is sent; none while
  /// the tool is held.
  int points = 0;
  std::array<ContactForce, std::tuple_size_v<decltype(StepReport::active)>> point;
  /// The groups of objects that move, relative to where their objects are placed.
  std::size_t moved = 0;
  std::array<Pose, kMostMoved> X_moved;
};

/// The servo loop of one session: answers each pose with a wrench when the pose arrives.
///
/// A pose is used if it is finite and within 100 m, its quaternion has a length, its sequence and
/// time grow, and the hand did not move faster than 5 m/s or 100 rad/s since the last used pose. A
/// repeated or late pose gets no answer.  Any other unusable pose holds the graphic tool, and the
/// force fades by a twentieth each time.  An apparent jump is accepted once five consecutive
/// samples agree on it, so that a hand that really is elsewhere is followed; the force then starts
/// from zero. It takes 200 samples to return to full force.  Samples are counted, not time: equal
/// inputs give equal bits.
///
/// Thread contract: OnPose in the servo thread; all else in one other thread, the service thread.
class ServoLoop {
 public:
  /// For a tool that is alone in its world.  Allocates what the steps need.
  explicit ServoLoop(const HapticModel& model);
  /// For a tool of a world in which hands meet.
  ServoLoop(std::shared_ptr<World> world, std::size_t tool);

  /// Answers a pose.  Returns false if there is nothing to send.
  /// Real-time: no allocation, lock or log; the clock only feeds the statistics.
  bool OnPose(const wire::HapticPose& pose, wire::Wrench& answer) noexcept;

  /// Puts the graphic tool at X_WG and lets forces begin, from the next pose on.
  void Start(const Pose& X_WG) { start_.Write(X_WG); }
  /// Sequence number of the first pose after Start, the first whose wrench is computed; 0 before.
  std::uint64_t start_sequence() const { return start_sequence_.load(std::memory_order_acquire); }
  /// Where hands meet: counts how often a Start was void because another tool was there, or the
  /// tool was let go.  Forces need another Start then.
  std::uint32_t voids() const { return voids_.load(std::memory_order_acquire); }
  /// Makes the scene whole again before the next pose's step.  Restored material may lie where the
  /// tool is, so there are no forces from that pose on, until a Start that follows made_whole().
  void MakeWhole();
  /// Returns whether the loop has carried out the last MakeWhole, if any.
  bool made_whole() const {
    return period_.load(std::memory_order_acquire) == newest_.load(std::memory_order_relaxed);
  }
  /// Returns whether no block was given since the last MakeWhole.  Until the next Start, this
  /// loop's own bur changes none either.
  bool was_given_nothing() const { return !was_given_; }
  /// Returns, one at a time, the poses before which the loop made the scene whole.
  bool TakeWhole(std::uint64_t& pose_sequence) { return wholes_.Pop(pose_sequence); }
  /// Takes the next block that the loop's bur changed.  A block is told again as long as it
  /// changes, some milliseconds late; the last copy is the valid one.  is_current returns false for
  /// a block that was changed before the last MakeWhole.  Which blocks come, and in what order,
  /// depends only on the poses and CutBlock::held_from.
  bool TakeCut(CutBlock& block) { return cut_blocks_ && cut_blocks_->Pop(block); }
  bool is_current(const CutBlock& block) const {
    return block.period == newest_.load(std::memory_order_relaxed);
  }
  /// For a replay: sets whether the loop shall find no room for such blocks.
  void HoldCuts(bool hold) { cuts_held_ = hold; }
  /// Once no pose can come: the pose since which blocks have been waiting for room; 0 if none wait.
  std::uint64_t held_from() const { return held_from_; }
  /// Gives the loop a block that another bur has changed, if wants_cuts(); the loop merges a few
  /// before each pose and sets the block's period.
  void GiveCut(CutBlock& block);
  bool wants_cuts() const { return given_ && !given_->full(); }
  /// Returns whether the loop has merged all blocks that it was given.
  bool has_merged() const { return !given_ || given_->size() == 0; }
  /// Takes the next record of what the loop began to merge.  The records, with the poses, starts,
  /// wholes and blocks, reproduce the same bits.
  bool TakeMerge(CutMerge& merge) { return merges_ && merges_->Pop(merge); }
  /// What burs removed from each solid.  Use it only before the first pose, or after the last.
  std::vector<CutField>& cuts() { return state().cut.fields; }
  /// Call after the last pose: where hands meet, the others' world goes on without this one.
  void Leave() noexcept;
  /// Valid after the last pose: its sequence number, and how many poses were answered.
  std::uint64_t last_sequence() const { return last_sequence_; }
  std::uint32_t answers() const { return answers_; }
  /// Reads the latest step.  Returns false if there was none since the last call.
  bool ReadSnapshot(LoopSnapshot& snapshot) { return snapshots_.Read(snapshot); }
  /// Number of poses heard, without mere repetitions; does not change while the station is silent.
  std::uint64_t heard() const { return heard_.load(std::memory_order_relaxed); }
  /// Requests the counters since the last report, which come with the next pose.
  void RequestCounters() { counters_wanted_.store(true, std::memory_order_relaxed); }
  bool ReadCounters(LoopCounters& counters) { return reports_.Read(counters); }

 private:
  const HapticModel& model() const { return world_->model(tool_); }
  StepState& state() { return world_->state(tool_); }
  double& gain() { return world_->gain(tool_); }  // part of the wrench that is sent, 0 to 1
  void TakeStart(std::uint64_t pose_sequence) noexcept;
  void LoseStart() noexcept;
  bool InSequence(const wire::HapticPose& pose) noexcept;
  /// Sets X_WH_ if the pose can be used; otherwise returns the fault.
  std::uint32_t UsePose(const wire::HapticPose& pose) noexcept;
  void BecomeWhole(std::uint64_t pose_sequence) noexcept;
  void Step(wire::Wrench& answer) noexcept;
  void TellCuts(std::uint64_t pose_sequence) noexcept;
  void MergeCuts(std::uint64_t pose_sequence, std::size_t given) noexcept;
  void Hold(std::uint32_t fault, wire::Wrench& answer) noexcept;
  void Report(wire::Wrench& answer, std::int64_t taken_ns) noexcept;

  std::shared_ptr<World> world_;
  std::size_t tool_;
  std::uint32_t hand_;
  bool started_ = false;
  Pose X_WG_;    // as sent last
  Wrench full_;  // the last step's wrench, unscaled
  EffectWrenches effects_;
  LoopSnapshot snapshot_;

  std::uint32_t answers_ = 0;
  bool heard_any_ = false;
  std::uint64_t last_sequence_ = 0;
  std::int64_t last_time_ns_ = 0;

  // The last pose that was used, and the apparent jump.
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
  std::atomic<std::uint32_t> voids_{0};
  LatestMailbox<Pose> start_;
  LatestMailbox<LoopSnapshot> snapshots_;
  LatestMailbox<LoopCounters> reports_;
  // Null if nothing can be cut.
  std::unique_ptr<Ring<CutBlock, 256>> cut_blocks_;  // loop -> service thread
  std::unique_ptr<Ring<CutBlock, 64>> given_;        // service thread -> loop
  std::unique_ptr<Ring<CutMerge, 64>> merges_;       // loop -> service thread
  std::uint64_t held_from_ = 0;
  std::size_t merging_ = 0;  // blocks of given_ announced by the last CutMerge, not yet merged
  bool cuts_held_ = false;
  bool was_given_ = false;  // service thread: whether any block was given since the last MakeWhole
  std::atomic<std::uint32_t> newest_{0};  // number of calls of MakeWhole
  std::atomic<std::uint32_t> period_{0};  // the call that the loop has carried out
  Ring<std::uint64_t, 16> wholes_;        // loop -> service thread
};

}  // namespace palpate
