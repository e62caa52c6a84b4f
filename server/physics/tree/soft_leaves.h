#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/contact_id.h"
#include "server/physics/limits.h"

namespace palpate {

class ObjectForest;

/// Depth of a soft leaf's rigid core (limits::kSoftShare) below the leaf's surface [m]; 0 where the
/// material is rigid.
inline double CoreDepth(const Material& material, double leaf_radius) {
  return material.stiffness < std::numeric_limits<double>::infinity()
             ? limits::kSoftShare * leaf_radius
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
  /// Rigid for a row that is not between leaves.
  Leaf of(const ContactId& id) const {
    return id.IsOfLeaves() ? leaves_[static_cast<std::size_t>(id.object)] : Leaf{};
  }

 private:
  std::vector<Leaf> leaves_;
};

}  // namespace palpate
