#include "server/physics/tree/soft_leaves.h"

#include <cmath>
#include <string>

#include "common/error.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

std::unique_ptr<const SoftLeaves> SoftLeaves::Make(const ObjectForest& objects,
                                                   double coupling_stiffness) {
  auto soft = std::make_unique<SoftLeaves>();
  bool any = false;
  soft->leaves_.resize(static_cast<std::size_t>(objects.leaf_count()));
  for (int i = 0; i < objects.leaf_count(); ++i) {
    const Material& material = objects.MaterialOf(i);
    const double stiffness = material.stiffness;
    if (!(stiffness > 0.0)) {
      throw Error("materials: stiffness " + std::to_string(stiffness) + " N/m of object " +
                  std::to_string(objects.ObjectOf(i)) +
                  "; give a positive number, or none for a rigid material");
    }
    if (std::isinf(stiffness)) continue;
    const auto leaf = static_cast<std::size_t>(i);
    soft->leaves_[leaf] = {stiffness / coupling_stiffness,
                           CoreDepth(material, objects.leaves()[leaf].radius)};
    any = true;
  }
  if (!any) return nullptr;
  return soft;
}

}  // namespace palpate
