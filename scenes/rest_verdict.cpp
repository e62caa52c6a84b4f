#include <algorithm>
#include <cstdio>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/scene_verdict.h"

namespace palpate {
namespace {

constexpr std::size_t kSamples = 10007;  // of a surface; a prime, as other measurements use

/// An object of the scene, ready to be compared with others.
struct Placed {
  explicit Placed(const Body& object) : body(object), query(object.mesh) {
    for (const Vec3& v : object.mesh.vertices) box.extend(v);
    points = object.mesh.vertices;
    for (const SurfaceSample& s :
         ScatterSamples(object.mesh, InspectMesh(object.mesh), query, kSamples)) {
      points.push_back(s.point);
    }
  }
  const Body& body;
  MeshQuery query;
  Eigen::AlignedBox3d box;   ///< frame B
  std::vector<Vec3> points;  ///< of the surface, frame B
};

/// Returns how deep points of a's surface lie in b [m]; 0: none does.
double DepthOf(const Placed& a, const Placed& b) {
  const Pose X_BA = b.body.X_WB.Inverse() * a.body.X_WB;
  double depth = 0.0;
  for (const Vec3& point : a.points) {
    const Vec3 p = X_BA * point;
    if (!b.box.contains(p) || !b.query.Inside(p)) continue;
    depth = std::max(depth, b.query.Nearest(p).distance);
  }
  return depth;
}

bool IsFree(const Scene& scene, const Body& object) {
  return object.moved > 0 && scene.moved[object.moved - 1].free.has_value();
}

Eigen::AlignedBox3d BoxInW(const Body& object) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : object.mesh.vertices) box.extend(object.X_WB * v);
  return box;
}

}  // namespace

Verdict JudgeRest(const Scene& scene) {
  Verdict verdict;
  const std::vector<Body>& all = scene.objects;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!IsFree(scene, all[i])) continue;
    const Placed body(all[i]);
    const Eigen::AlignedBox3d box = BoxInW(all[i]);
    for (std::size_t j = 0; j < all.size(); ++j) {
      const bool was_seen = j <= i && IsFree(scene, all[j]);
      if (was_seen || !box.intersects(BoxInW(all[j]))) continue;
      const Placed other(all[j]);
      const double depth = std::max(DepthOf(body, other), DepthOf(other, body));
      if (depth <= scene.tuning.separation) continue;
      char text[32];
      std::snprintf(text, sizeof text, "%.3g mm", 1e3 * depth);
      verdict.faults.push_back("objects " + all[i].name + " and " + all[j].name + ": overlap by " +
                               text + " where they are placed; move one of them, or drop \"free\"");
    }
  }
  return verdict;
}

}  // namespace palpate
