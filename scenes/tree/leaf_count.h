#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace palpate {

/// The accuracy that a body's leaves must have, given instead of their number.
struct LeafTolerance {
  enum class Of {
    kHeight,  ///< UnionError::off_p95: error in height for a hand that slides over the leaves
    kLean,    ///< UnionError::mean_lean: error in the direction of the force
  };
  Of of = Of::kHeight;
  double most = 0.0;            ///< [m] or [rad]; 0: kAutoShare of the box's diagonal
  std::size_t most_leaves = 0;  ///< 0: kMostByTolerance
  bool operator==(const LeafTolerance&) const = default;
};

/// The tolerance "auto", as a share of the diagonal of the body's box: 0.2 mm on a model of 100 mm,
/// which fills the hand, and there a finger does not notice it.
inline constexpr double kAutoShare = 1.0 / 500.0;
/// The first count that is tried: fewer leaves hardly describe any shape, and take as long.
inline constexpr std::size_t kFewestByTolerance = 64;
/// The default of most_leaves.  All trees that are tried have three times as many leaves together,
/// which takes seconds, or a minute if leaves are moved ("balanced").
inline constexpr std::size_t kMostByTolerance = 16384;

/// Limits of a tolerance: less cannot be felt, and with more the leaves do not represent the mesh.
inline constexpr double kLeastTolerance_um = 0.1, kMostTolerance_um = 1e6;
inline constexpr double kLeastTolerance_deg = 0.01, kMostTolerance_deg = 90.0;

/// The result of ChooseLeafCount.
struct LeafCount {
  std::size_t count = 0;
  double error = 0.0;  ///< with `count` leaves
  bool reached = false;
  int tried = 0;  ///< number of counts tried
};

/// Is told, before a count is tried, the count and the estimated share of all work that is done
/// before and after it.
using LeafCountProgress = std::function<void(std::size_t count, double from, double to)>;

/// Returns the fewest leaves whose error is at most `tolerance`.  Tries kFewestByTolerance, then
/// doubles, then bisects the last interval in the logarithm with three more counts, so the result
/// is within a tenth of the least.  A tighter tolerance never gives fewer leaves, whatever the
/// errors are.  Returns `most` if no count up to it is enough.
/// `error_of`: returns the error of a count of leaves; called at most once for each.
LeafCount ChooseLeafCount(double tolerance, std::size_t most,
                          const std::function<double(std::size_t count)>& error_of,
                          const LeafCountProgress& progress = {});

/// Returns a tolerance as text, exactly: different tolerances have different texts.
std::string ToText(const LeafTolerance& tolerance);
/// Returns for people: "1,240 leaves for 100 um: 94 um off at 95 of 100 places (9 counts tried)".
/// `bound`: the value of `tolerance.most` for the body's size.
std::string ToText(const LeafCount& chosen, const LeafTolerance& tolerance, double bound);

}  // namespace palpate
