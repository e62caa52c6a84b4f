#include "scenes/tree/sphere_tree_builder.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/error.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/tree/leaf_maker.h"
#include "scenes/tree/sphere_hierarchy.h"

namespace palpate {
namespace {

/// Gives every leaf the triangles that it stands for: those that lie nearest to it, told by points
/// all over the surface, of which every triangle has at least one.
/// @param samples  of the mesh's own triangles.
void ShareOutTriangles(const TriangleMesh& mesh, const std::vector<SurfaceSample>& samples,
                       SphereTree& tree) {
  std::vector<Sphere> balls;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    balls.push_back({{tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]}, tree.leaf_radius[i]});
  }
  const SphereQuery query(std::move(balls));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // leaf, triangle
  pairs.reserve(samples.size() + mesh.triangles.size());
  for (const SurfaceSample& s : samples) {
    pairs.push_back({query.Nearest(s.point).ball, s.triangle});
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 middle = (mesh.vertices[i] + mesh.vertices[j] + mesh.vertices[k]) / 3.0;
    pairs.push_back({query.Nearest(middle).ball, t});
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  tree.leaf_triangle_begin.assign(tree.leaves() + 1, 0);
  for (const auto& [leaf, triangle] : pairs) {
    ++tree.leaf_triangle_begin[leaf + 1];
    tree.leaf_triangle.push_back(triangle);
  }
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    tree.leaf_triangle_begin[i + 1] += tree.leaf_triangle_begin[i];
  }
}

/// The one way from balls to a tree, wherever they come from.
SphereTree Assemble(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                    const std::vector<SurfaceSample>& samples, const Vec3& centroid,
                    const Progress& progress = {}) {
  if (progress) progress("arranging the tree", 0.8);
  SphereTree tree = ArrangeLeaves(balls).tree;
  if (progress) progress("sharing out triangles", 0.9);
  ShareOutTriangles(mesh, samples, tree);
  tree.centroid = centroid;
  if (progress) progress("done", 1.0);
  return tree;
}

/// The samples of what a mesh's solid has of the mesh itself, by the mesh's triangles.
std::vector<SurfaceSample> SamplesOfMesh(const MeshSolid& solid, const TriangleMesh& mesh,
                                         std::vector<SurfaceSample> samples) {
  for (SurfaceSample& s : samples) s.triangle = solid.OriginOf(s.triangle, mesh.triangles.size());
  std::erase_if(samples, [](const SurfaceSample& s) { return s.triangle == MeshSolid::kNone; });
  return samples;
}

/// Throws where the mesh cannot be rendered, before a solid is made of it.
Vec3 CentroidOf(const TriangleMesh& mesh) {
  const MeshReport report = InspectMesh(mesh);
  if (!report.refusal.empty()) throw Error(report.refusal);
  return report.centroid;
}

}  // namespace

SphereTree BuildSphereTree(const TriangleMesh& mesh, std::size_t count, const Progress& progress,
                           TreeMode mode) {
  if (count == 0) throw Error("a sphere tree of 0 leaves is not possible; ask for at least 1");
  if (progress) progress("inspecting", 0.0);
  const Vec3 centroid = CentroidOf(mesh);
  const MeshSolid solid = SolidOf(mesh);
  if (progress) progress("scattering samples", 0.05);
  const SampledSolid sampled(solid.mesh, count);
  const std::vector<Sphere> leaves = MakeLeaves(sampled, count, mode, progress);
  return Assemble(mesh, leaves, SamplesOfMesh(solid, mesh, sampled.samples), centroid, progress);
}

SphereTree TreeOverBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls) {
  if (balls.empty()) throw Error("a sphere tree of 0 leaves is not possible; give at least 1");
  const Vec3 centroid = CentroidOf(mesh);
  const MeshSolid solid = SolidOf(mesh);
  const SampledSolid sampled(solid.mesh, balls.size());
  return Assemble(mesh, balls, SamplesOfMesh(solid, mesh, sampled.samples), centroid);
}

SphereTree SingleSphereTree(const TriangleMesh& mesh, const Sphere& ball) {
  return Assemble(mesh, {ball}, {}, ball.centre);
}

}  // namespace palpate
