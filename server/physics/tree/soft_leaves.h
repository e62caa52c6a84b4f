#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/leaf_pair.h"

namespace palpate {

class ObjectForest;

/// How far a soft leaf lets itself be entered, as a share of its radius: inside is a rigid core
/// with the same centre.  The force goes on without a jump where the core is met, only its slope
/// changes; the normal cannot flip, for no ball gets past the centre of another.
inline constexpr double kSoftShare = 0.5;

/// Depth of that core below the leaf's surface [m]; 0 where the material is rigid.
inline double CoreDepth(const Material& material, double leaf_radius) {
  return material.stiffness < std::numeric_limits<double>::infinity() ? kSoftShare * leaf_radius
                                                                      : 0.0;
}

/// What a leaf's finite stiffness means to the step.  Immutable.
class SoftLeaves {
 public:
  struct Leaf {
    double weight = 0.0;  ///< stiffness over that of the coupling: 1 / c; 0 where it is rigid
    double depth = 0.0;   ///< CoreDepth [m]
  };
  /// Null where no leaf is soft.  Throws Error where a stiffness is not positive.
  static std::unique_ptr<const SoftLeaves> Make(const ObjectForest& objects,
                                                double coupling_stiffness);
  /// What has a surface is rigid.
  Leaf of(const LeafPair& pair) const {
    return KindOf(pair) == RowKind::kLeaves ? leaves_[static_cast<std::size_t>(pair.object)]
                                            : Leaf{};
  }

 private:
  std::vector<Leaf> leaves_;
};

}  // namespace palpate
