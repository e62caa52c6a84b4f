#include "server/library/body_builder.h"

#include <cmath>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>

#include "common/error.h"
#include "common/math/default_rounding.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/triangle.h"
#include "scenes/mesh/units.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate {
namespace {

constexpr std::size_t kBallTriangles = 5120;  // within 2 um of a ball of 10 mm

}  // namespace

std::string MetresRemark(const TriangleMesh& mesh) {
  const double longest = BoxOf(mesh).sizes().maxCoeff();
  const auto likely = LikelierUnit(longest, 1.0);
  if (!likely) return "";
  std::ostringstream text;
  text << "its longest side is " << longest << " m, which a hand hardly feels";
  if (!likely->empty()) {
    text << "; its numbers are more likely " << *likely << ": multiply them by "
         << MetresPerUnit(*likely);
  }
  if (longest < kShortestByMesh) text << "; if they are metres, " << kTooShortByMesh;
  return text.str();
}

Body MakeBody(std::string name, TriangleMesh mesh, const BodyOptions& options) {
  const DefaultRounding rounding;
  Body body;
  try {
    CheckNumbers(mesh);
    if (const MeshReport report = InspectMesh(mesh); !report.refusal.empty()) {
      throw Error(report.refusal);
    }
    body.remarks = MendMesh(mesh);
    for (std::string& remark : InspectMesh(mesh).remarks) body.remarks.push_back(std::move(remark));
    if (std::string remark = MetresRemark(mesh); !remark.empty()) {
      body.remarks.push_back(std::move(remark));
    }
    const TreeMode mode = ModeFor(options.contact);
    const bool felt_by_leaves =
        options.contact == ContactModel::kSpheres || std::isfinite(options.material.stiffness);
    if (options.leaves > 0) {
      body.tree = BuildSphereTree(mesh, options.leaves, options.progress, mode);
    } else if (!felt_by_leaves) {
      body.tree = BuildInnerTree(mesh);
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
  const DefaultRounding rounding;
  if (!(radius > 0.0) || !std::isfinite(radius)) {
    throw Error(name + ": a ball's radius must be above 0 m; it is " + std::to_string(radius));
  }
  Body body;
  body.mesh = MakeSphere(radius, kBallTriangles);
  body.tree = SingleSphereTree(body.mesh, {Vec3::Zero(), radius});
  body.name = std::move(name);
  body.materials = {material};
  if (std::string remark = MetresRemark(body.mesh); !remark.empty()) {
    body.remarks.push_back(std::move(remark));
  }
  return body;
}

}  // namespace palpate
