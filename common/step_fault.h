#pragma once

#include <cstdint>
#include <string>

namespace palpate {

/// Why a step is not what was asked for: a bitfield, because several can be true at once.
/// None of them stops the loop; each is counted and published (Wrench.faults).
enum StepFault : std::uint32_t {
  kFaultNone = 0,
  /// The pose was not finite or its quaternion had no length.  The graphic tool stays where it was.
  /// The step's wrench is zero; the servo loop does not step, and its last wrench fades by a
  /// twentieth for each such pose.  Remedy: mend the device driver.
  kFaultBadPose = 1u << 0,
  /// The target lay further than all sub-steps of one cycle reach.  The graphic tool is on its way;
  /// the wrench is that of the contacts met so far, zero in free space.  No remedy needed.
  kFaultTargetFar = 1u << 1,
  /// More pairs within reach than rows fit: the tightest were kept.  Remedy: fewer leaves, or a
  /// larger StepParameters::max_rows.
  kFaultRowsFull = 1u << 2,
  /// The rows contradict each other (a jam): all were relaxed by the same least amount.
  kFaultJammed = 1u << 3,
  /// A QP did not end within its iterations, or not with numbers; the tool stays, and the wrench
  /// is the spring's from there.  Should never happen: keep the dump (`palpate-bench qp --dump`).
  kFaultUnsolved = 1u << 4,
  /// A force of one's own failed, or gave no number that a force can have.  It is zero, and off for
  /// the rest of the session.  Remedy: mend the effect.
  kFaultEffect = 1u << 5,
  // Set by the servo loop (server/session), not by the step:
  /// The pose was further from the last than a hand comes: the wrench fades as for kFaultBadPose,
  /// until poses that agree with each other show that the hand is there.
  kFaultPoseRejected = 1u << 9,
  kFaultNotStarted = 1u << 10,  ///< the tool starts inside an object, or no pose came yet
};

/// The bits in words, for people: "rows full, jammed"; "none" where there is none.  Not real-time.
std::string FaultWords(std::uint32_t faults);

/// The same with what each means: "target far (the hand was quicker than the tool, which
/// follows)".
std::string FaultMeanings(std::uint32_t faults);

}  // namespace palpate
