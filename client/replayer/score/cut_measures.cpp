#include "client/replayer/score/cut_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "common/error.h"
#include "scenes/mesh/mesh_query.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSteepestShoulder = 45.0 * kDegree, kMostTaper = 30.0 * kDegree;
// A smaller angle is within the error of the grid's triangles.
constexpr double kUndercut = 1.0 * kDegree;
/// Directions round an axis in which a border is measured; number of neighbours on either side that
/// smooth it; and those that average a shoulder's width, as not every direction has an edge.
constexpr int kDirections = 360, kSmoothed = 10, kTogether = 3;

const Body& BodyOf(const SolidsCut& cut, std::size_t solid) {
  return cut.scene->objects[cut.objects->solids[solid].object];
}

const std::string& NameOf(const Body& body, std::size_t material) {
  const std::string& name = body.materials[material].name;
  return name.empty() ? body.name : name;
}

/// Calls visit(material, i, j, k) for each lattice point of a solid's block in a place.
template <class Visit>
void EachPoint(const CutSolid& solid, std::size_t block, const Place& place, Visit visit) {
  const Lattice& lattice = solid.grid->field().lattice();
  const auto [bi, bj, bk] = lattice.BlockAt(block);
  for (int n = 0; n < SparseField::kPoints; ++n) {
    const int i = 8 * bi + (n & 7), j = 8 * bj + (n >> 3 & 7), k = 8 * bk + (n >> 6);
    if (place && !place->Holds(solid.X_WB * lattice.Point(i, j, k))) continue;
    visit(solid.grid->MaterialOf(block, n), i, j, k);
  }
}

double VoxelOf(const CutSolid& solid) {
  return 1e9 * std::pow(solid.grid->field().lattice().spacing, 3);
}

using Volumes = std::array<double, SolidGrid::kMaterials>;  // [voxels]

Volumes VolumesOf(const CutSolid& solid, const CutField& left, std::size_t block,
                  const Place& place) {
  Volumes volumes{};
  EachPoint(solid, block, place, [&](std::size_t material, int i, int j, int k) {
    volumes[material] += left.Left(i, j, k);
  });
  return volumes;
}

bool IsWhole(const CutField& left, std::size_t block) {
  return left.field().entry(block) == SparseField::kBelow;
}

/// The mean of observations in each direction round an axis.
class Round {
 public:
  Round(const Vec3& middle, const Vec3& axis) : middle_(middle), axis_(axis) {
    u_ = axis.unitOrthogonal();
    v_ = axis.cross(u_);
  }
  void Add(const Vec3& p, double weight) {
    const Vec3 from = p - middle_;
    const double turn = std::atan2(from.dot(v_), from.dot(u_)) / (2.0 * std::numbers::pi);
    const int place = static_cast<int>(std::floor(turn * kDirections));
    At& at = at_[static_cast<std::size_t>((place + kDirections) % kDirections)];
    at.radius += weight * (from - from.dot(axis_) * axis_).norm();
    at.height += weight * from.dot(axis_);
    at.weight += weight;
  }
  struct At {
    double radius = 0.0, height = 0.0, weight = 0.0;
  };
  /// Returns the mean over a direction and its neighbours; none without an observation there.
  std::optional<At> Mean(int direction, int beside = 0) const {
    At sum;
    for (int d = direction - beside; d <= direction + beside; ++d) {
      const At& at = at_[static_cast<std::size_t>((d + kDirections) % kDirections)];
      if (at.weight == 0.0) continue;
      sum.radius += at.radius / at.weight;
      sum.height += at.height / at.weight;
      sum.weight += 1.0;
    }
    if (sum.weight == 0.0) return std::nullopt;
    return At{sum.radius / sum.weight, sum.height / sum.weight, 1.0};
  }

 private:
  Vec3 middle_, axis_, u_, v_;
  std::array<At, kDirections> at_{};
};

/// Returns the rms deviation of a border from its mean over neighbouring directions [m].
double RoughnessOf(const Round& border) {
  double squares = 0.0;
  int count = 0;
  for (int d = 0; d < kDirections; ++d) {
    const auto here = border.Mean(d);
    if (!here) continue;
    const auto near = border.Mean(d, kSmoothed);
    const double radius = here->radius - near->radius;
    const double height = here->height - near->height;
    squares += radius * radius + height * height;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) : 0.0;
}

/// A region of a tissue, for the distance of points outside it.
class Region {
 public:
  explicit Region(const MaterialRegion& region) : region_(region) {
    if (!region.mesh.triangles.empty()) query_.emplace(region.mesh);
  }
  /// Returns the distance, at most `within`; 0 inside.
  double DistanceTo(const Vec3& p_B, double within) const {
    if (query_) {
      const double distance = query_->Nearest(p_B, within).distance;
      return distance < within && query_->Inside(p_B) ? 0.0 : std::min(distance, within);
    }
    if (region_.radius > 0.0) {
      return std::clamp((p_B - region_.low).norm() - region_.radius, 0.0, within);
    }
    const Vec3 nearest = p_B.cwiseMax(region_.low).cwiseMin(region_.high);
    return std::min((p_B - nearest).norm(), within);
  }

 private:
  const MaterialRegion& region_;
  std::optional<MeshQuery> query_;
};

std::vector<Region> RegionsOf(const Body& body, const std::string& tissue) {
  std::vector<Region> regions;
  for (const MaterialRegion& region : body.grid->regions) {
    if (NameOf(body, region.material) == tissue) regions.emplace_back(region);
  }
  return regions;
}

}  // namespace

std::vector<TissueCut> TissuesOf(const SolidsCut& cut, const Place& place, WholeVolumes* whole) {
  std::vector<TissueCut> tissues;
  std::vector<std::array<std::size_t, SolidGrid::kMaterials>> places(cut.after.size());
  for (std::size_t s = 0; s < cut.after.size(); ++s) {
    const Body& body = BodyOf(cut, s);
    for (std::size_t m = 0; m < body.materials.size(); ++m) {
      const std::string& name = NameOf(body, m);
      auto tissue = std::ranges::find(tissues, name, &TissueCut::name);
      if (tissue == tissues.end()) tissue = tissues.insert(tissue, TissueCut{name});
      places[s][m] = static_cast<std::size_t>(tissue - tissues.begin());
    }
  }
  WholeVolumes once;
  WholeVolumes& known = whole != nullptr && !place ? *whole : once;
  known.resize(cut.after.size());
  for (std::size_t s = 0; s < cut.after.size(); ++s) {
    const CutSolid& solid = cut.objects->solids[s];
    const auto volumes = [&](const CutField& left, std::size_t block) {
      if (!IsWhole(left, block)) return VolumesOf(solid, left, block, place);
      const auto [at, is_new] = known[s].try_emplace(block);
      if (is_new) at->second = VolumesOf(solid, left, block, place);
      return at->second;
    };
    const double voxel = VoxelOf(solid);
    for (std::size_t block = 0; block < solid.grid->field().lattice().block_count(); ++block) {
      if (solid.grid->field().entry(block) == SparseField::kAbove) continue;
      const Volumes before = volumes(cut.before[s], block), after = volumes(cut.after[s], block);
      for (std::size_t m = 0; m < BodyOf(cut, s).materials.size(); ++m) {
        tissues[places[s][m]].before_mm3 += voxel * before[m];
        tissues[places[s][m]].after_mm3 += voxel * after[m];
      }
    }
  }
  return tissues;
}

std::vector<SolidSurface> SurfacesOf(const SolidsCut& cut) {
  std::vector<SolidSurface> surfaces;
  for (const CutField& left : cut.after) surfaces.push_back(WholeSurface(left));
  return surfaces;
}

TargetDifference DifferenceTo(const SolidsCut& target, const SolidsCut& cut,
                              const std::string& tissue, const Place& place) {
  TargetDifference difference;
  for (std::size_t s = 0; s < cut.after.size(); ++s) {
    const CutSolid& solid = cut.objects->solids[s];
    const double voxel = VoxelOf(solid);
    for (std::size_t block = 0; block < solid.grid->field().lattice().block_count(); ++block) {
      const bool differs = !IsWhole(cut.after[s], block) || !IsWhole(target.after[s], block);
      if (!differs || solid.grid->field().entry(block) == SparseField::kAbove) continue;
      EachPoint(solid, block, place, [&](std::size_t material, int i, int j, int k) {
        if (!tissue.empty() && NameOf(BodyOf(cut, s), material) != tissue) return;
        const double more = voxel * (cut.after[s].Left(i, j, k) - target.after[s].Left(i, j, k));
        (more > 0.0 ? difference.missed_mm3 : difference.excess_mm3) += std::abs(more);
      });
    }
  }
  return difference;
}

CutShape::CutShape(const SolidsCut& cut, const std::vector<SolidSurface>& surfaces,
                   std::vector<TissueCut> tissues)
    : cut_(cut), tissues_(std::move(tissues)) {
  for (std::size_t s = 0; s < cut.after.size(); ++s) {
    const CutSolid& solid = cut.objects->solids[s];
    const SolidSurface& surface = surfaces[s];
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (const Vec3& p_B : surface.vertices) vertices_.push_back(solid.X_WB * p_B);
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3 &p = surface.vertices[a], &q = surface.vertices[b], &r = surface.vertices[c];
      const Vec3 twice = (q - p).cross(r - p), middle_B = (p + q + r) / 3.0;
      const bool is_cut =
          cut.after[s].field().Sample(middle_B).distance > solid.grid->Sample(middle_B).distance;
      triangles_.push_back({{first + a, first + b, first + c},
                            solid.X_WB.q * twice.normalized(),
                            solid.X_WB * middle_B,
                            0.5 * twice.norm(),
                            is_cut});
    }
  }
  std::unordered_map<std::uint64_t, std::uint32_t> open;  // by corners: the edge's first triangle
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const auto& corners = triangles_[t].corners;
      const auto [a, b] = std::minmax(corners[static_cast<std::size_t>(c)],
                                      corners[static_cast<std::size_t>((c + 1) % 3)]);
      const std::uint64_t key = std::uint64_t{a} << 32 | b;
      const auto [it, is_new] = open.try_emplace(key, t);
      if (!is_new) edges_.push_back({a, b, {it->second, t}});
    }
  }
}

std::optional<double> CutShape::ThicknessOver(const std::string& tissue, const Place& place) const {
  double least = std::numeric_limits<double>::infinity();
  bool painted = false;
  const bool any_cut = std::ranges::any_of(triangles_, &Triangle::is_cut);
  for (std::size_t s = 0; s < cut_.after.size(); ++s) {
    const std::vector<Region> regions = RegionsOf(BodyOf(cut_, s), tissue);
    painted = painted || !regions.empty();
    const Pose X_BW = cut_.objects->solids[s].X_WB.Inverse();
    for (const Triangle& triangle : triangles_) {
      if (triangle.is_cut != any_cut) continue;
      for (const std::uint32_t corner : triangle.corners) {
        const Vec3& p_W = vertices_[corner];
        if (place && !place->Holds(p_W)) continue;
        for (const Region& region : regions) {
          least = std::min(least, region.DistanceTo(X_BW * p_W, least));
        }
      }
    }
  }
  if (!painted) {
    throw Error("no region of the scene paints '" + tissue +
                "'; give a tissue that one paints, as the pulp");
  }
  if (std::isinf(least)) return std::nullopt;
  return 1e3 * least;
}

std::vector<bool> CutShape::ShoulderFrom(const Vec3& axis, const std::vector<bool>& inside) const {
  const auto may_be = [&](std::uint32_t t) {
    return triangles_[t].is_cut && inside[t] &&
           triangles_[t].normal.dot(axis) > std::cos(kSteepestShoulder);
  };
  std::vector<std::vector<std::uint32_t>> beside(triangles_.size());
  std::vector<bool> shoulder(triangles_.size());
  std::vector<std::uint32_t> waiting;
  const auto take = [&](std::uint32_t t) {
    if (shoulder[t]) return;
    shoulder[t] = true;
    waiting.push_back(t);
  };
  for (const Edge& edge : edges_) {
    const auto [s, t] = edge.triangles;
    if (may_be(s) && may_be(t)) {
      beside[s].push_back(t);
      beside[t].push_back(s);
    }
    if (may_be(s) && !triangles_[t].is_cut) take(s);
    if (may_be(t) && !triangles_[s].is_cut) take(t);
  }
  while (!waiting.empty()) {
    const std::uint32_t t = waiting.back();
    waiting.pop_back();
    for (const std::uint32_t next : beside[t]) take(next);
  }
  return shoulder;
}

Preparation CutShape::PreparationAlong(const Vec3& axis, const Place& place) const {
  std::vector<bool> inside(triangles_.size());
  for (std::size_t t = 0; t < inside.size(); ++t) {
    inside[t] = !place || place->Holds(triangles_[t].middle);
  }
  Preparation found;
  AddWalls(axis, inside, found);
  AddBorder(axis, inside, found);
  return found;
}

void CutShape::AddWalls(const Vec3& axis, const std::vector<bool>& inside,
                        Preparation& found) const {
  std::vector<std::pair<double, double>> walls;  // angle, area
  double all = 0.0, undercut = 0.0, below = 0.0;
  for (std::size_t t = 0; t < inside.size(); ++t) {
    const double angle = std::asin(std::clamp(triangles_[t].normal.dot(axis), -1.0, 1.0));
    if (!triangles_[t].is_cut || !inside[t] || std::abs(angle) > kMostTaper) continue;
    walls.emplace_back(angle, triangles_[t].area);
    all += triangles_[t].area;
    if (angle < -kUndercut) undercut += triangles_[t].area;
  }
  std::ranges::sort(walls);
  for (const auto& [angle, area] : walls) {
    below += area;
    if (below < 0.5 * all) continue;
    found.taper_deg = angle / kDegree;
    found.undercut_share = undercut / all;
    return;
  }
}

void CutShape::AddBorder(const Vec3& axis, const std::vector<bool>& inside,
                         Preparation& found) const {
  const std::vector<bool> shoulder = ShoulderFrom(axis, inside);
  std::vector<std::pair<Vec3, double>> border, foot;  // midpoints and lengths of edges
  Vec3 middle = Vec3::Zero();
  double length = 0.0;
  for (const Edge& edge : edges_) {
    const auto [s, t] = edge.triangles;
    const Vec3 p = 0.5 * (vertices_[edge.a] + vertices_[edge.b]);
    const double l = (vertices_[edge.a] - vertices_[edge.b]).norm();
    if (triangles_[s].is_cut != triangles_[t].is_cut) {
      if (!inside[triangles_[s].is_cut ? s : t]) continue;
      border.emplace_back(p, l);
      middle += l * p;
      length += l;
    } else if (shoulder[s] != shoulder[t]) {
      foot.emplace_back(p, l);
    }
  }
  if (border.empty()) return;
  Round outer(middle / length, axis), inner(middle / length, axis);
  for (const auto& [p, l] : border) outer.Add(p, l);
  for (const auto& [p, l] : foot) inner.Add(p, l);
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (int d = 0; d < kDirections; ++d) {
    const auto from = outer.Mean(d, kTogether), to = inner.Mean(d, kTogether);
    if (!from) continue;
    const double width = to ? from->radius - to->radius : 0.0;
    sum += width;
    squares += width * width;
    ++count;
  }
  const double mean = sum / count;
  found.width_mm = 1e3 * mean;
  found.spread_mm = 1e3 * std::sqrt(std::max(0.0, squares / count - mean * mean));
  found.roughness_mm = 1e3 * RoughnessOf(outer);
}

}  // namespace palpate
