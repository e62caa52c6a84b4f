#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/math/pose.h"

namespace palpate::test {

/// What a trace of forces, one a millisecond, looks like: holes that close again, and changes that
/// stay.  A pure function of the trace: it knows no contact, no tool and no step.
///
///     |F|   before             after        A notch: the force falls below half of what it was,
///       ----------.        .----------      and is back above 60 % of that within 10 ms.  Neither
///     0.6 - - - - | - - - -|- - - - -       the fall nor the return is what the hand has done.
///     0.5 - - - - | - - - -|- - - - -
///                 '--------'  least
///               begin     end               A ledge: the force changes, and stays changed.
///
/// Steps of the force itself are told from those of a fast hand by `by_hand`, see JudgeForce.
struct ForceNotch {
  std::size_t begin = 0, end = 0;  ///< the last step before the fall, the first one that is back
  double before = 0.0, least = 0.0, after = 0.0;  ///< |F| at begin, least between, at end [N]
  std::size_t steps() const { return end - begin - 1; }  ///< in between: milliseconds
  double depth() const { return before - least; }        ///< [N]
};

/// From one step to the next.
struct ForceChange {
  std::size_t step = 0;  ///< that it leads to
  double size = 0.0;     ///< |dF| [N]
};

struct ForceShape {
  std::vector<ForceNotch> notches;  ///< in their order; none begins before the last one's end
  /// Changes outside of notches by more than kJump and more than the hand's.  Those that stay: for
  /// 10 ms the force comes no nearer to what it was than 40 % of the change.  And those that pass:
  /// it does; the way back is then no change of its own.
  std::vector<ForceChange> ledges, passing;
  ForceChange largest_jump;  ///< of all steps, whatever made it
};

/// At most, from `begin` to the first step below half, and from that to `end`.
inline constexpr std::size_t kNotchSteps = 10;
inline constexpr double kFallen = 0.5, kBack = 0.6;  ///< of the force before

/// Falls and changes are those of forces above kJump (jump_cause.h).  What begins less than 10 ms
/// before the end, and has not ended there, is neither notch nor ledge.
/// @param by_hand  for each step the most that the hand can have changed the force by since the one
///                 before [N]; empty: nothing.
ForceShape JudgeForce(std::span<const Vec3> force, std::span<const double> by_hand = {});

/// The one of most depth; all zero where there is none.
ForceNotch Deepest(std::span<const ForceNotch> notches);
/// The one of most steps.
ForceNotch Longest(std::span<const ForceNotch> notches);
ForceChange Largest(std::span<const ForceChange> changes);

}  // namespace palpate::test
