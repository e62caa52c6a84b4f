#pragma once

#include <cstdint>
#include <string>

namespace palpate {

/// The reasons why a step's result is not the one requested: a bit field, because several can hold
/// at once.  No fault stops the loop; each is counted and published (Wrench.faults).
enum StepFault : std::uint32_t {
  kFaultNone = 0,
  /// The pose was not finite or its quaternion had zero length.  The graphic tool stays where it
  /// was. The step returns a zero wrench; the servo loop does not step, and reduces its last wrench
  /// by a twentieth for each such pose.  Remedy: correct the device driver.
  kFaultBadPose = 1u << 0,
  /// The target lay beyond what all sub-steps of one cycle can reach.  The graphic tool is still on
  /// its way; the wrench is that of the contacts met so far, zero in free space.  No remedy needed.
  kFaultTargetFar = 1u << 1,
  /// There were more pairs than rows even where the tool hardly moves.  It stays, and the pairs
  /// found first give the wrench.  Remedy: fewer leaves, or a larger StepParameters::max_rows.
  kFaultRowsFull = 1u << 2,
  /// The rows contradicted each other (a jam): all were relaxed by the same amount, the
  /// least possible.
  kFaultJammed = 1u << 3,
  /// A QP reached its iteration limit or gave numbers that are not finite.  The tool stays, and
  /// the wrench is the spring's at that pose.  Should never happen: keep the dump (`palpate-bench
  /// qp --dump`).
  kFaultUnsolved = 1u << 4,
  /// An effect (a user's own force) failed, or returned a value that no force can have.  Its force
  /// is zero, and stays off for the rest of the session.  Remedy: correct the effect.
  kFaultEffect = 1u << 5,
  /// No frictional optimum was found.  The last cycle's friction stays, within the limits of the
  /// normal forces.  Should never happen.
  kFaultFriction = 1u << 6,
  // Set by the servo loop (server/session), not by the step:
  /// The pose was further from the last one than a hand can move: the wrench fades as for
  /// kFaultBadPose until several consistent poses show that the hand is really there.
  kFaultPoseRejected = 1u << 9,
  kFaultNotStarted = 1u << 10,  ///< the tool starts inside an object, or no pose has come yet
};

/// Returns the bits in words, for people: "rows full, jammed"; "none" if no bit is set.
/// Not real-time.
std::string FaultWords(std::uint32_t faults);

/// Returns the bits in words, each with its meaning:
/// "target far (the hand moved faster than the tool, which follows)".
std::string FaultMeanings(std::uint32_t faults);

}  // namespace palpate
