#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/math/pose.h"

namespace palpate::test {

/// The shape of a trace of forces, one per millisecond: notches that close again, and changes that
/// stay.  A pure function of the trace, without knowledge of contacts, the tool or the step.
///
///     |F|   before             after        A notch: the force falls below half of what it was,
///       ----------.        .----------      and is back above 60 % of that within 10 ms.  Neither
///     0.6 - - - - | - - - -|- - - - -       the fall nor the return is what the hand has done.
///     0.5 - - - - | - - - -|- - - - -
///                 '--------'  least
///               begin     end               A ledge: the force changes, and stays changed.
///
/// `by_hand` of JudgeForce distinguishes jumps of the force from changes by a fast hand.
struct ForceNotch {
  std::size_t begin = 0, end = 0;  ///< the last step before the fall, the first after the return
  double before = 0.0, least = 0.0, after = 0.0;         ///< |F| at begin, least, at end [N]
  std::size_t steps() const { return end - begin - 1; }  ///< steps in between, one per millisecond
  double depth() const { return before - least; }        ///< [N]
};

/// A change of the force from one step to the next.
struct ForceChange {
  std::size_t step = 0;  ///< the later step
  double size = 0.0;     ///< |dF| [N]
};

struct ForceShape {
  std::vector<ForceNotch> notches;  ///< in order; none begins before the end of the previous one
  /// Changes outside of notches by more than kJump and more than the hand explains.  Ledges stay:
  /// for 10 ms the force comes no nearer to its former value than 40 % of the change.  Passing ones
  /// return; the return does not count as another change.
  std::vector<ForceChange> ledges, passing;
  ForceChange largest_jump;  ///< over all steps, from any cause
};

/// Greatest number of steps from `begin` to the first step below half, and from there to `end`.
inline constexpr std::size_t kNotchSteps = 10;
inline constexpr double kFallen = 0.5, kBack = 0.6;  ///< relative to the force before

/// Only falls and changes of forces above kJump (jump_cause.h) count.  An event that begins less
/// than 10 ms before the end of the trace, and has not ended there, is neither notch nor ledge.
/// @param by_hand  for each step the greatest change of the force since the previous one that the
/// hand can have caused [N]; empty: none.
ForceShape JudgeForce(std::span<const Vec3> force, std::span<const double> by_hand = {});

/// Returns the deepest notch; all zero if there is none.
ForceNotch Deepest(std::span<const ForceNotch> notches);
ForceNotch Longest(std::span<const ForceNotch> notches);
ForceChange Largest(std::span<const ForceChange> changes);

}  // namespace palpate::test
