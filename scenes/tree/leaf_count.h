#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace palpate {

/// Changes with every change of what ChooseLeafCount chooses, so that cached scenes are built anew.
inline constexpr std::uint32_t kLeafCountVersion = 1;

/// How true the leaves of a body must be to its mesh, in place of how many there are.
struct LeafTolerance {
  enum class Of {
    kHeight,  ///< UnionError::off_p95: how far off a hand is that slides over the leaves
    kLean,    ///< UnionError::mean_lean: how far off the force's direction is
  };
  Of of = Of::kHeight;
  double most = 0.0;            ///< [m] or [rad]; 0: kAutoShare of the diagonal of the box
  std::size_t most_leaves = 0;  ///< 0: kMostByTolerance
  bool operator==(const LeafTolerance&) const = default;
};

/// Of the diagonal of the body's box: what "auto" means.  A finger does not find it on a model that
/// fills the hand: 0.2 mm of 100 mm.
inline constexpr double kAutoShare = 1.0 / 500.0;
/// The first count that is tried: fewer say little of any shape, and cost as much.
inline constexpr std::size_t kFewestByTolerance = 64;
/// Where nobody says otherwise.  The trees that are tried have three times as many leaves together:
/// seconds, and a minute for those that are moved about ("balanced", "cover").
inline constexpr std::size_t kMostByTolerance = 16384;

/// What may be asked for: below, nothing that is felt; above, nothing that stands for the mesh.
inline constexpr double kLeastTolerance_um = 0.1, kMostTolerance_um = 1e6;
inline constexpr double kLeastTolerance_deg = 0.01, kMostTolerance_deg = 90.0;

/// How many leaves are enough.
struct LeafCount {
  std::size_t count = 0;
  double error = 0.0;  ///< with these
  bool reached = false;
  int tried = 0;  ///< counts
};

/// Told before a count is tried: which, and how much of the work that is likely to come is done
/// before it and after it.
using LeafCountProgress = std::function<void(std::size_t count, double from, double to)>;

/// The fewest leaves whose error is at most `tolerance`: tried are kFewestByTolerance and twice as
/// many each time, then three counts between the last two, by halves of their logarithm, so that
/// the answer is within a tenth of the least.  A tighter tolerance never gives fewer, whatever the
/// errors are.  Where no count up to `most` is enough, `most`.
/// `error_of`: of the leaves of a count; asked at most once for each.
LeafCount ChooseLeafCount(double tolerance, std::size_t most,
                          const std::function<double(std::size_t count)>& error_of,
                          const LeafCountProgress& progress = {});

/// What is asked for, to the last bit: two that differ have different texts.
std::string ToText(const LeafTolerance& tolerance);
/// For people: "1,240 leaves for 100 um: 94 um off at 95 of 100 places (9 counts tried)".
/// `bound`: what `tolerance.most` stands for, in the body's size.
std::string ToText(const LeafCount& chosen, const LeafTolerance& tolerance, double bound);

}  // namespace palpate
