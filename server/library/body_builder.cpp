#include "server/library/body_builder.h"

#include <cmath>
#include <utility>

#include "common/error.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate {
namespace {

constexpr std::size_t kBallTriangles = 5120;  // within 2 um of a ball of 10 mm

}  // namespace

Body MakeBody(std::string name, TriangleMesh mesh, const BodyOptions& options) {
  Body body;
  try {
    if (const MeshReport report = InspectMesh(mesh); !report.refusal.empty()) {
      throw Error(report.refusal);
    }
    body.remarks = MendMesh(mesh);
    const TreeMode mode = ModeFor(options.contact);
    const bool felt_by_leaves = options.contact == ContactModel::kSpheres ||
                                std::isfinite(options.material.stiffness) ||
                                std::isfinite(options.material.hardness);
    std::size_t leaves = options.leaves;
    if (leaves == 0 && !felt_by_leaves) leaves = kLeavesBesideMesh;
    if (leaves > 0) {
      body.tree = BuildSphereTree(mesh, leaves, options.progress, mode);
    } else {
      TolerantTree built = BuildToTolerance(mesh, LeafTolerance{}, options.progress, mode);
      if (!built.shortfall.empty()) body.remarks.push_back(std::move(built.shortfall));
      body.tree = std::move(built.tree);
    }
  } catch (const Error& error) {
    throw Error(name + ": " + error.what());
  }
  body.name = std::move(name);
  body.mesh = std::move(mesh);
  body.materials = {options.material};
  return body;
}

Body MakeBall(std::string name, double radius, const Material& material) {
  if (!(radius > 0.0) || !std::isfinite(radius)) {
    throw Error(name + ": a ball's radius must be above 0 m; it is " + std::to_string(radius));
  }
  Body body;
  body.mesh = MakeSphere(radius, kBallTriangles);
  body.tree = SingleSphereTree(body.mesh, {Vec3::Zero(), radius});
  body.name = std::move(name);
  body.materials = {material};
  return body;
}

}  // namespace palpate
