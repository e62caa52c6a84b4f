#include "scenes/mesh/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

/// Random numbers by splitmix64 (Steele, Lea & Flood, OOPSLA 2014), the same with
/// every standard library.
class Random {
 public:
  double Uniform() {  // [0, 1)
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 0;
};

/// Returns a point, uniformly distributed over the triangle.
Vec3 PointOf(const TriangleMesh& mesh, std::size_t triangle, Random& random) {
  const double root = std::sqrt(random.Uniform());
  const double v = root * random.Uniform();
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (1.0 - root) * mesh.vertices[a] + (root - v) * mesh.vertices[b] + v * mesh.vertices[c];
}

/// Returns whether a sample is on a wall, with solid on both sides, by winding numbers `step` away.
bool IsWall(const MeshQuery& query, const SurfaceSample& s, double step) {
  return query.Inside(s.point - step * s.outward) && query.Inside(s.point + step * s.outward);
}

/// A place where a ball can roll: a face, the arc of directions at an edge, the cap at a corner.
struct RolledOver {
  enum class Kind : std::uint8_t { kFace, kEdge, kCorner } kind;
  std::uint32_t triangle;
  std::uint32_t from = 0, to = 0;  ///< vertices of an edge; for a corner, `from`
  Vec3 a = Vec3::Zero();  ///< normals on both sides of an edge; for a corner, the axis of its cap
  Vec3 b = Vec3::Zero();
  double cosine = 1.0;  ///< of the angle between a and b, or of the cap's half angle
};

/// All such places, each with the area of the ball's centres over it, or a little more: the excess
/// is rejected when points are drawn.
class RolledSurface {
 public:
  RolledSurface(const TriangleMesh& mesh, const MeshQuery& query, double height)
      : mesh_(mesh), query_(query), height_(height) {
    struct Side {
      std::uint32_t low, high, triangle;
      bool operator<(const Side& other) const {
        return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
      }
    };
    std::vector<Side> sides;
    std::vector<Vec3> axes(mesh.vertices.size(), Vec3::Zero());
    std::vector<Vec3> normals;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [i, j, k] = mesh.triangles[t];
      normals.push_back(query.FaceNormal(t));
      if (normals[t].isZero()) continue;
      Add({RolledOver::Kind::kFace, t}, TriangleOf(mesh, t).Area());
      for (const auto& [v, w] : {std::pair{i, j}, std::pair{j, k}, std::pair{k, i}}) {
        sides.push_back({std::min(v, w), std::max(v, w), t});
        axes[v] += normals[t];
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
      if (sides[s].low != sides[s + 1].low || sides[s].high != sides[s + 1].high) continue;
      AddEdge(sides[s].low, sides[s].high, sides[s].triangle, sides[s + 1].triangle, normals);
    }
    AddCorners(axes, normals);
  }

  double area() const { return area_to_.empty() ? 0.0 : area_to_.back(); }

  /// @param at  share of the area, 0 to 1, never less than in the last call.
  /// @returns false: reject the point, because it counts too much or does not exist.
  bool Draw(double at, Random& random, SurfaceSample& sample) {
    while (next_ + 1 < area_to_.size() && area_to_[next_] <= at * area()) ++next_;
    const RolledOver& part = parts_[next_];
    sample.triangle = part.triangle;
    Vec3 foot;
    switch (part.kind) {
      case RolledOver::Kind::kFace:
        foot = PointOf(mesh_, part.triangle, random);
        sample.outward = part.a;
        break;
      case RolledOver::Kind::kEdge: {
        const double share = random.Uniform();
        foot = (1.0 - share) * mesh_.vertices[part.from] + share * mesh_.vertices[part.to];
        // On the chord between both normals, the middle maps most densely to the arc: 1/|chord|^2.
        const double along = random.Uniform();
        const Vec3 chord = (1.0 - along) * part.a + along * part.b;
        const double squared = chord.squaredNorm();
        if (random.Uniform() * squared > 0.5 * (1.0 + part.cosine)) return false;
        sample.outward = chord / std::sqrt(squared);
        break;
      }
      case RolledOver::Kind::kCorner:
        foot = mesh_.vertices[part.from];
        sample.outward = DirectionIn(part, random);
        break;
    }
    sample.point = foot + height_ * sample.outward;
    return query_.Nearest(sample.point, (1.0 - 1e-6) * height_).triangle == MeshQuery::kNone;
  }

  void Rewind() { next_ = 0; }

 private:
  void Add(RolledOver part, double area) {
    if (!(area > 0.0)) return;
    if (part.kind == RolledOver::Kind::kFace) part.a = query_.FaceNormal(part.triangle);
    parts_.push_back(part);
    area_to_.push_back(area_to_.empty() ? area : area_to_.back() + area);
  }

  void AddEdge(std::uint32_t from, std::uint32_t to, std::uint32_t s, std::uint32_t t,
               const std::vector<Vec3>& normals) {
    const Vec3 along = mesh_.vertices[to] - mesh_.vertices[from];
    const double cosine = normals[s].dot(normals[t]);
    for (const std::uint32_t v : mesh_.triangles[t]) {
      if (normals[s].dot(mesh_.vertices[v] - mesh_.vertices[from]) > 0.0 && v != from && v != to) {
        return;  // a crease
      }
    }
    if (!(cosine > -0.99)) return;  // a fold: the corners at its ends have caps
    // Twice the tangent of half the angle: the arc's length, if it had the density of its middle.
    const double tangent = normals[s].cross(normals[t]).norm() / (1.0 + cosine);
    Add({RolledOver::Kind::kEdge, s, from, to, normals[s], normals[t], cosine},
        2.0 * tangent * height_ * along.norm());
  }

  void AddCorners(std::vector<Vec3>& axes, const std::vector<Vec3>& normals) {
    std::vector<double> cosine(axes.size(), 1.0);
    std::vector<std::uint32_t> triangle(axes.size(), 0);
    for (Vec3& axis : axes) {
      axis.stableNormalize();
      if (axis.isZero()) axis = Vec3::UnitZ();  // a fold: try every direction
    }
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (normals[t].isZero()) continue;
      for (const std::uint32_t v : mesh_.triangles[t]) {
        cosine[v] = std::min(cosine[v], axes[v].dot(normals[t]));
        triangle[v] = t;
      }
    }
    for (std::uint32_t v = 0; v < axes.size(); ++v) {
      if (cosine[v] < 0.1) cosine[v] = -1.0;  // a spike, which may touch with any side
      Add({RolledOver::Kind::kCorner, triangle[v], v, v, axes[v], Vec3::Zero(), cosine[v]},
          2.0 * M_PI * (1.0 - cosine[v]) * height_ * height_);
    }
  }

  /// Returns a direction, uniformly distributed over the cap.
  static Vec3 DirectionIn(const RolledOver& cap, Random& random) {
    const double z = 1.0 - random.Uniform() * (1.0 - cap.cosine);
    double x = 0.0, y = 0.0, squared = 0.0;
    do {
      x = 2.0 * random.Uniform() - 1.0;
      y = 2.0 * random.Uniform() - 1.0;
      squared = x * x + y * y;
    } while (!(squared > 0.0 && squared <= 1.0));
    const double across = std::sqrt(std::max(0.0, 1.0 - z * z) / squared);
    const Vec3 first = cap.a.unitOrthogonal();
    return z * cap.a + across * (x * first + y * cap.a.cross(first));
  }

  const TriangleMesh& mesh_;
  const MeshQuery& query_;
  double height_;
  std::vector<RolledOver> parts_;
  std::vector<double> area_to_;
  std::size_t next_ = 0;
};

}  // namespace

double PoissonRadius(double area, std::size_t count) {
  return std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
}

std::vector<SurfaceSample> ScatterSamples(const TriangleMesh& mesh, const MeshReport& report,
                                          const MeshQuery& query, std::size_t count) {
  std::vector<double> area_to(mesh.triangles.size());
  double total = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    total += TriangleOf(mesh, t).Area();
    area_to[t] = total;
  }
  const bool no_walls = report.solid() && report.components == 1;
  const double step = 0.05 * PoissonRadius(report.area, count);
  Random random;
  std::vector<SurfaceSample> samples;
  std::vector<SurfaceSample> walls;
  std::size_t t = 0;
  for (std::size_t k = 0; k < count; ++k) {
    // One sample in every count-th part of the area: more even than independent samples.
    const double at = (static_cast<double>(k) + random.Uniform()) / static_cast<double>(count);
    while (t + 1 < area_to.size() && area_to[t] <= at * total) ++t;
    SurfaceSample s;
    s.triangle = static_cast<std::uint32_t>(t);
    s.point = PointOf(mesh, t, random);
    s.outward = query.FaceNormal(s.triangle);
    if (s.outward.isZero()) continue;
    (!no_walls && IsWall(query, s, step) ? walls : samples).push_back(s);
  }
  return samples.empty() ? walls : samples;
}

std::vector<SurfaceSample> ScatterAbove(const TriangleMesh& mesh, const MeshReport& report,
                                        const MeshQuery& query, double height, std::size_t count) {
  RolledSurface surface(mesh, query, height);
  const bool nothing_inside = report.solid() && report.components == 1;
  std::vector<SurfaceSample> samples;
  // Draw a few to learn which share can be used, and then enough.
  std::size_t drawn = count / 8 + 1;
  for (int pass = 0; pass < 2; ++pass) {
    Random random;
    surface.Rewind();
    samples.clear();
    for (std::size_t k = 0; k < drawn; ++k) {
      SurfaceSample s;
      const double at = (static_cast<double>(k) + random.Uniform()) / static_cast<double>(drawn);
      if (!surface.Draw(at, random, s)) continue;
      if (nothing_inside || !query.Inside(s.point)) samples.push_back(s);
    }
    if (samples.empty()) return samples;
    const double enough = double(drawn) * double(count) / double(samples.size());
    drawn = static_cast<std::size_t>(std::min(enough, 8.0 * double(count)));
  }
  return samples;
}

std::vector<std::uint32_t> ThinOut(const std::vector<SurfaceSample>& samples, std::size_t keep,
                                   double area) {
  const std::size_t count = samples.size();
  const double radius = PoissonRadius(area, keep);
  const double reach = 2.0 * radius;
  // Yuksel's constants: beta 0.65, gamma 1.5, alpha 8.
  const double ratio = static_cast<double>(keep) / static_cast<double>(count);
  const double nearest = 2.0 * radius * (1.0 - ratio * std::sqrt(ratio)) * 0.65;

  // Sort samples into cells of the size of the reach; neighbours are in the 27 cells around.
  Vec3 low = samples[0].point;
  for (const SurfaceSample& s : samples) low = low.cwiseMin(s.point);
  const auto cell = [&](const Vec3& p) -> Eigen::Matrix<std::int64_t, 3, 1> {
    return ((p - low) / reach).array().floor().cast<std::int64_t>();
  };
  const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return (x + 1) | (y + 1) << 21 | (z + 1) << 42;
  };
  std::vector<std::pair<std::int64_t, std::uint32_t>> by_cell(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto c = cell(samples[i].point);
    by_cell[i] = {key(c.x(), c.y(), c.z()), i};
  }
  std::sort(by_cell.begin(), by_cell.end());
  std::unordered_map<std::int64_t, std::uint32_t> begin;
  begin.reserve(count);
  for (std::uint32_t k = 0; k < count; ++k) begin.try_emplace(by_cell[k].first, k);

  struct Neighbour {
    std::uint32_t sample;
    float weight;
  };
  std::vector<Neighbour> neighbours;
  std::vector<std::uint32_t> neighbours_begin(count + 1, 0);
  std::vector<double> weight(count, 0.0);
  for (std::uint32_t i = 0; i < count; ++i) {
    neighbours_begin[i] = static_cast<std::uint32_t>(neighbours.size());
    const auto c = cell(samples[i].point);
    for (int n = 0; n < 27; ++n) {
      const std::int64_t k = key(c.x() + n % 3 - 1, c.y() + n / 3 % 3 - 1, c.z() + n / 9 - 1);
      const auto it = begin.find(k);
      if (it == begin.end()) continue;
      for (std::uint32_t m = it->second; m < count && by_cell[m].first == k; ++m) {
        const std::uint32_t j = by_cell[m].second;
        if (j == i || !(samples[i].outward.dot(samples[j].outward) > 0.0)) continue;
        const double d = (samples[i].point - samples[j].point).norm();
        if (!(d < reach)) continue;
        double w = 1.0 - std::max(d, nearest) / reach;
        w *= w;
        w *= w;
        w *= w;
        neighbours.push_back({j, static_cast<float>(w)});
        weight[i] += static_cast<float>(w);
      }
    }
  }
  neighbours_begin[count] = static_cast<std::uint32_t>(neighbours.size());

  // Weights only fall, so an entry whose weight has changed is inserted again at its new weight.
  std::priority_queue<std::pair<double, std::uint32_t>> crowded;
  for (std::uint32_t i = 0; i < count; ++i) crowded.push({weight[i], i});
  std::vector<bool> removed(count, false);
  for (std::size_t left = count; left > keep;) {
    const auto [w, i] = crowded.top();
    crowded.pop();
    if (w != weight[i]) {
      crowded.push({weight[i], i});
      continue;
    }
    removed[i] = true;
    --left;
    for (std::uint32_t n = neighbours_begin[i]; n < neighbours_begin[i + 1]; ++n) {
      weight[neighbours[n].sample] -= neighbours[n].weight;
    }
  }
  std::vector<std::uint32_t> kept;
  kept.reserve(keep);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!removed[i]) kept.push_back(i);
  }
  return kept;
}

}  // namespace palpate
