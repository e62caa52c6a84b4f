#include "scenes/mesh/mesh_report.h"

#include <algorithm>
#include <limits>
#include <span>

#include "common/error.h"
#include "scenes/mesh/disjoint_sets.h"
#include "scenes/mesh/mesh_edges.h"

namespace palpate {
namespace {

void CountEdges(std::span<const Side> sides, MeshReport& report) {
  report.boundary_edges += sides.size() == 1;
  report.non_manifold_edges += sides.size() > 2;
  report.inconsistent_edges += sides.size() == 2 && sides[0].forward == sides[1].forward;
}

std::string Count(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

void Judge(MeshReport& r) {
  const double longest = (r.box_max - r.box_min).maxCoeff();
  if (r.triangles == 0) {
    r.refusal = "the mesh has no triangles; export surfaces, not only points, lines or curves";
  } else if (r.bad_triangles > 0) {
    r.refusal = Count(r.bad_triangles, "triangle names", "triangles name") +
                " a vertex that does not exist; the file is damaged, export it again";
  } else if (r.non_finite_vertices > 0) {
    r.refusal = Count(r.non_finite_vertices, "vertex is", "vertices are") +
                " not finite (NaN or infinity); the file is damaged, export it again";
  } else if (!(longest > 0.0) || !(r.area > 0.0)) {
    r.refusal =
        "the mesh has no extent: all of its triangles are degenerate; check the exported scale";
  }
  if (!r.refusal.empty()) return;
  if (!r.closed()) {
    r.remarks.push_back(Count(r.boundary_edges, "edge is", "edges are") +
                        " open: the winding number determines what is inside, and spheres may "
                        "protrude through large holes; close them in a mesh editor");
  }
  if (!r.manifold()) {
    r.remarks.push_back(Count(r.non_manifold_edges, "edge has", "edges have") +
                        " more than two triangles: walls inside are ignored, and sheets attached "
                        "to the body are felt; remove them in a mesh editor");
  }
  if (!r.oriented()) {
    r.remarks.push_back(Count(r.inconsistent_edges, "edge joins", "edges join") +
                        " triangles that wind against each other: the fewer of them are turned; "
                        "recalculate the normals in a mesh editor");
  }
  if (r.inside_out()) {
    r.remarks.push_back(
        "the mesh is inside out: all of it is turned; flip its normals in a mesh editor");
  }
  if (r.degenerate_triangles > 0) {
    r.remarks.push_back(Count(r.degenerate_triangles, "triangle has", "triangles have") +
                        " no area: ignored");
  }
  if (r.duplicate_triangles > 0) {
    r.remarks.push_back(Count(r.duplicate_triangles, "triangle stands", "triangles stand") +
                        " there twice: merge by distance in a mesh editor");
  }
  if (r.unused_vertices > 0) {
    r.remarks.push_back(Count(r.unused_vertices, "vertex belongs", "vertices belong") +
                        " to no triangle: ignored");
  }
}

}  // namespace

MeshReport InspectMesh(const TriangleMesh& mesh) {
  MeshReport r;
  r.vertices = mesh.vertices.size();
  r.triangles = mesh.triangles.size();

  std::vector<bool> finite(r.vertices);
  for (std::size_t v = 0; v < r.vertices; ++v) finite[v] = mesh.vertices[v].allFinite();
  r.non_finite_vertices = std::count(finite.begin(), finite.end(), false);

  std::vector<bool> used(r.vertices, false);
  DisjointSets pieces(r.vertices);
  std::vector<Corners> usable;
  usable.reserve(r.triangles);
  r.box_min = Vec3::Constant(std::numeric_limits<double>::infinity());
  r.box_max = -r.box_min;
  Vec3 solid_moment = Vec3::Zero();
  Vec3 surface_moment = Vec3::Zero();
  Vec3 origin =
      Vec3::Zero();  // near the mesh, so that volumes far from the origin of W keep their precision
  for (const auto& triangle : mesh.triangles) {
    const auto [i, j, k] = triangle;
    if (i >= r.vertices || j >= r.vertices || k >= r.vertices) {
      ++r.bad_triangles;
      continue;
    }
    if (!(finite[i] && finite[j] && finite[k])) continue;
    if (usable.empty()) origin = mesh.vertices[i];
    for (std::uint32_t v : triangle) {
      used[v] = true;
      r.box_min = r.box_min.cwiseMin(mesh.vertices[v]);
      r.box_max = r.box_max.cwiseMax(mesh.vertices[v]);
    }
    usable.push_back(triangle);
    pieces.Join(i, j);
    pieces.Join(j, k);
    const Vec3 a = mesh.vertices[i] - origin;
    const Vec3 b = mesh.vertices[j] - origin;
    const Vec3 c = mesh.vertices[k] - origin;
    const double area = 0.5 * (b - a).cross(c - a).norm();
    if (!(area > 0.0)) {
      ++r.degenerate_triangles;
      if (i == j || j == k || k == i) continue;  // it has no three edges
    }
    r.area += area;
    surface_moment += area / 3.0 * (a + b + c);
    const double volume = a.dot(b.cross(c)) / 6.0;
    r.volume += volume;
    solid_moment += volume / 4.0 * (a + b + c);
  }
  if (usable.empty()) r.box_min = r.box_max = Vec3::Zero();
  EdgeSides(usable, r.vertices).ForEachEdge([&r](std::span<const Side> sides) {
    CountEdges(sides, r);
  });
  r.duplicate_triangles = std::ranges::count(FindRepeated(usable, r.vertices), true);
  for (std::uint32_t v = 0; v < r.vertices; ++v) {
    r.unused_vertices += !used[v];
    r.components += used[v] && pieces.Find(v) == v;
  }
  if (r.solid() && r.volume != 0.0) {
    r.centroid = origin + solid_moment / r.volume;
  } else if (r.area > 0.0) {
    r.centroid = origin + surface_moment / r.area;
  }
  Judge(r);
  return r;
}

void CheckNumbers(const TriangleMesh& mesh) {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v].allFinite()) continue;
    throw Error("vertex " + std::to_string(v) + ", from 0, is not finite; leave it out");
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v < mesh.vertices.size()) continue;
      throw Error("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + " of " +
                  std::to_string(mesh.vertices.size()) + "; both count from 0");
    }
  }
}

}  // namespace palpate
