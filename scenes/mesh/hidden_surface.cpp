#include "scenes/mesh/hidden_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

// As a share of the way to a triangle's middle: on an edge, the neighbours would count, too.
constexpr double kFromTheEdge = 0.1;
// As a share of a triangle's size: the distance from its plane at which the winding
// number is taken.
constexpr double kStep = 1e-3;
// Outside an exposed surface the winding number is 0.  On either side of a sheet inside a solid it
// is at least 1/2, because the sheet removes at most half of the solid's 1.
constexpr double kHidden = 0.25;
// As a share of the surface: neighbouring parts of one model may overlap by less, from rounding.
constexpr double kWorthSaying = 1e-4;
constexpr std::size_t kMostTriangles = 20000;  // examined at most, evenly spread over the mesh

// Number of triangles to examine for whether a single solid piece passes through itself.
constexpr std::size_t kHiddenProbes = 128;

}  // namespace

HiddenSurface::HiddenSurface(const TriangleMesh& mesh)
    : mesh_(mesh), query_(mesh), possible_(true) {
  const MeshReport report = InspectMesh(mesh);
  closed_ = report.closed();
  if (!report.solid() || report.components > 1) return;
  const std::size_t count = mesh.triangles.size(), probes = std::min(kHiddenProbes, count);
  bool folds = false;
  for (std::size_t i = 0; !folds && i < probes; ++i) {
    const auto t = static_cast<std::uint32_t>(i * count / probes);
    const Triangle corners = TriangleOf(mesh, t);
    folds = Places(t, {corners.a, corners.b, corners.c}) == kAllPlaces;
  }
  possible_ = folds;
}

bool HiddenSurface::HiddenAt(std::uint32_t triangle, const Vec3& p) const {
  const double area = TriangleOf(mesh_, triangle).Area();
  const Vec3 step = kStep * std::sqrt(area) * query_.FaceNormal(triangle);
  return query_.WindingNumber(p + step) > kHidden && query_.WindingNumber(p - step) > kHidden;
}

int HiddenSurface::Places(std::uint32_t triangle, const std::array<Vec3, 3>& part) const {
  if (!possible_ || !(TriangleOf(mesh_, triangle).Area() > 0.0)) return 0;
  const Vec3 middle = (part[0] + part[1] + part[2]) / 3.0;
  int places = HiddenAt(triangle, middle);
  for (const Vec3& corner : part) {
    places += HiddenAt(triangle, corner + kFromTheEdge * (middle - corner));
  }
  return places;
}

bool HiddenSurface::At(std::uint32_t triangle, const Vec3& near) const {
  if (!possible_) return false;
  return HiddenAt(triangle, near + kFromTheEdge * (TriangleOf(mesh_, triangle).Middle() - near));
}

bool HiddenSurface::NearestTo(std::uint32_t triangle, const Vec3& p) const {
  const Triangle corners = TriangleOf(mesh_, triangle);
  return At(triangle, NearestOnTriangle(p, corners.a, corners.b, corners.c));
}

HiddenParts FindHiddenParts(const TriangleMesh& mesh, const std::vector<MeshGroup>& groups) {
  HiddenParts hidden;
  const HiddenSurface surface(mesh);
  std::vector<std::uint32_t> found;
  double looked_at = 0.0;
  double inside = 0.0;
  const std::size_t stride = 1 + mesh.triangles.size() / kMostTriangles;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); t += std::uint32_t(stride)) {
    const Triangle corners = TriangleOf(mesh, t);
    const std::array<Vec3, 4> points{corners.Middle(), corners.a, corners.b, corners.c};
    const double area = corners.Area();
    looked_at += area;
    if (!(area > 0.0)) continue;
    const auto is_hidden = [&](const Vec3& p) { return surface.At(t, p); };
    const auto first = std::ranges::find_if(points, is_hidden);
    if (first == points.end()) continue;
    if (found.empty()) hidden.at = *first;
    found.push_back(t);
    inside += area * double(std::ranges::count_if(points, is_hidden)) / double(points.size());
  }
  hidden.share = looked_at > 0.0 ? inside / looked_at : 0.0;
  for (const MeshGroup& group : groups) {
    const auto it = std::ranges::lower_bound(found, group.begin);
    if (it == found.end() || *it >= group.end) continue;
    if (std::ranges::find(hidden.of, group.name) == hidden.of.end())
      hidden.of.push_back(group.name);
  }
  return hidden;
}

std::string HiddenRemark(const HiddenParts& hidden, double scale, const std::string& unit) {
  if (hidden.share < kWorthSaying) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "parts overlap: %.2g %% of the surface lies inside other parts, as at (%.4g, %.4g, "
                "%.4g) %s",
                100.0 * hidden.share, scale * hidden.at.x(), scale * hidden.at.y(),
                scale * hidden.at.z(), unit.c_str());
  std::string remark = text;
  for (std::size_t i = 0; i < hidden.of.size(); ++i) {
    remark += (i == 0 ? ", of \"" : ", \"") + hidden.of[i] + "\"";
  }
  return remark +
         "; nothing can touch it there, and a material assigned to it counts only where it is "
         "exposed; unite the parts in the mesh editor if they should be one";
}

}  // namespace palpate
