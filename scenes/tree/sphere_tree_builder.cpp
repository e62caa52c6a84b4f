#include "scenes/tree/sphere_tree_builder.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/mesh/triangle.h"
#include "scenes/tree/inner_balls.h"
#include "scenes/tree/leaf_maker.h"
#include "scenes/tree/sphere_hierarchy.h"
#include "scenes/tree/tree_error.h"

namespace palpate {
namespace {

/// Assigns to every leaf the triangles that it represents: those that are nearest to it, judged at
/// samples all over the surface, at least one in each triangle.
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
    pairs.push_back({query.Nearest(TriangleOf(mesh, t).Middle()).ball, t});
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

/// Makes a tree of balls, wherever they come from.
SphereTree Assemble(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                    const std::vector<SurfaceSample>& samples, const Vec3& centroid,
                    const Progress& progress = {}) {
  if (progress) progress("building the tree", 0.8);
  SphereTree tree = ArrangeLeaves(balls).tree;
  if (progress) progress("assigning triangles", 0.9);
  ShareOutTriangles(mesh, samples, tree);
  tree.centroid = centroid;
  if (progress) progress("done", 1.0);
  return tree;
}

/// Returns those samples of a mesh's solid that lie on the mesh itself, with the mesh's triangles.
std::vector<SurfaceSample> SamplesOfMesh(const MeshSolid& solid, const TriangleMesh& mesh,
                                         std::vector<SurfaceSample> samples) {
  for (SurfaceSample& s : samples) s.triangle = solid.OriginOf(s.triangle, mesh.triangles.size());
  std::erase_if(samples, [](const SurfaceSample& s) { return s.triangle == MeshSolid::kNone; });
  return samples;
}

/// Returns the centroid; throws Error if the mesh cannot be rendered, before a solid is made of it.
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
  if (progress) progress("sampling the surface", 0.05);
  const SampledSolid sampled(solid.mesh, count);
  const std::vector<Sphere> leaves = MakeLeaves(sampled, count, mode, progress);
  SphereTree tree =
      Assemble(mesh, leaves, SamplesOfMesh(solid, mesh, sampled.samples), centroid, progress);
  tree.origin = OriginOf(mode);
  return tree;
}

SphereTree BuildInnerTree(const TriangleMesh& mesh) {
  constexpr double kPlaces = 512.0;  // 8 per side
  const MeshReport report = InspectMesh(mesh);
  if (!report.refusal.empty()) throw Error(report.refusal);
  const TriangleMesh solid = report.closed() ? mesh : SolidOf(mesh).mesh;
  const MeshReport of_solid = report.closed() ? report : InspectMesh(solid);
  const MeshQuery query(solid);
  const std::vector<Sphere> balls =
      InnerBalls(of_solid, query, 0.0).Fill({}, kInnerLeaves, kPlaces);
  if (balls.empty()) return BuildSphereTree(mesh, kInnerLeaves);  // no lattice point lies inside
  SphereTree tree = Assemble(mesh, balls, {}, report.centroid);
  tree.origin = TreeOrigin::kInside;
  return tree;
}

TolerantTree BuildToTolerance(const TriangleMesh& mesh, const LeafTolerance& tolerance,
                              const Progress& progress, TreeMode mode) {
  constexpr std::size_t kSamples = 10007;
  constexpr double kSearchShare = 0.9;  // of the work; Assemble has the rest
  const bool height = tolerance.of == LeafTolerance::Of::kHeight;
  if (progress) progress("inspecting", 0.0);
  const Vec3 centroid = CentroidOf(mesh);
  const MeshSolid solid = SolidOf(mesh);
  const SurfaceGauge gauge(solid.mesh, kSamples);
  const double bound = tolerance.most > 0.0 ? tolerance.most : kAutoShare * gauge.diagonal();
  const std::size_t most = tolerance.most_leaves > 0 ? tolerance.most_leaves : kMostByTolerance;

  // Keep the best tree tried, so that none is made twice: the last one that was sufficient, or the
  // one with the most leaves.
  std::vector<Sphere> best;
  std::vector<SurfaceSample> best_samples;
  std::size_t trying = 0;
  double begin = 0.0, end = 0.0;
  const auto tell = [&](std::string_view, double share) {
    if (!progress) return;
    progress("trying " + std::to_string(trying) + " leaves",
             kSearchShare * (begin + (end - begin) * share));
  };
  const auto error_of = [&](std::size_t count) {
    const SampledSolid sampled(solid.mesh, count);
    std::vector<Sphere> leaves = MakeLeaves(sampled, count, mode, tell);
    const UnionError measured = gauge.Measure(leaves, SurfaceGauge::Figures::kSurface);
    const double error = height ? measured.off_p95 : measured.mean_lean;
    if (error <= bound || count == most) {
      best = std::move(leaves);
      best_samples = sampled.samples;
    }
    return error;
  };
  const auto next = [&](std::size_t count, double from, double to) {
    trying = count;
    begin = from;
    end = to;
    tell("", 0.0);
  };
  TolerantTree built;
  built.chosen = ChooseLeafCount(bound, most, error_of, next);
  built.tree = Assemble(mesh, best, SamplesOfMesh(solid, mesh, best_samples), centroid);
  if (progress) progress("done", 1.0);
  built.tree.origin = OriginOf(mode);
  built.found = ToText(built.chosen, tolerance, bound);
  if (!built.chosen.reached) {
    built.shortfall =
        "the tolerance of its leaves is not reached: " + built.found + "; raise " +
        (height ? "tolerance_um" : "tolerance_deg") + " or most_leaves" +
        (mode == TreeMode::kBalanced ? "" : ", or take \"tree\": \"balanced\", which needs fewer");
  }
  return built;
}

SphereTree TreeOverBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls) {
  if (balls.empty()) throw Error("a sphere tree of 0 leaves is not possible; give at least 1");
  const Vec3 centroid = CentroidOf(mesh);
  const MeshSolid solid = SolidOf(mesh);
  const SampledSolid sampled(solid.mesh, balls.size());
  SphereTree tree = Assemble(mesh, balls, SamplesOfMesh(solid, mesh, sampled.samples), centroid);
  tree.origin = TreeOrigin::kFile;
  return tree;
}

SphereTree SingleSphereTree(const TriangleMesh& mesh, const Sphere& ball) {
  SphereTree tree = Assemble(mesh, {ball}, {}, ball.centre);
  tree.origin = TreeOrigin::kBall;
  return tree;
}

}  // namespace palpate
