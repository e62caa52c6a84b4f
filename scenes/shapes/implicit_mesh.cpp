#include "scenes/shapes/implicit_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "common/error.h"

namespace palpate {
namespace {

// Least distance of a vertex from the ends of its lattice edge, as a share: keeps
// triangles from degenerating.
constexpr double kNearestToEnd = 0.15;
constexpr int kSmoothings = 4;
constexpr int kNewtonSteps = 3;

/// A field sampled on a body-centred cubic lattice, and its surface.
class Lattice {
 public:
  Lattice(const Field& field, const Eigen::AlignedBox3d& box, double cell)
      : cell_(cell), origin_(box.min()) {
    for (int k = 0; k < 3; ++k) cells_[k] = int(std::ceil(box.sizes()[k] / cell)) + 1;
    corners_ = std::size_t(cells_[0] + 1) * (cells_[1] + 1) * (cells_[2] + 1);
    values_.reserve(corners_ + std::size_t(cells_[0]) * cells_[1] * cells_[2]);
    ForEach(cells_[0] + 1, cells_[1] + 1, cells_[2] + 1, [&](int i, int j, int k) {
      const double value = field(CornerAt(i, j, k));
      const bool border = i * j * k == 0 || i == cells_[0] || j == cells_[1] || k == cells_[2];
      if (border && value < 0.0) throw Error("an implicit surface leaves its box; enlarge the box");
      values_.push_back(value);
    });
    ForEach(cells_[0], cells_[1], cells_[2], [&](int i, int j, int k) {
      values_.push_back(field(CornerAt(i, j, k) + Vec3::Constant(0.5 * cell_)));
    });
  }

  /// Makes the surface.  Every tetrahedron joins the centres of two neighbouring cells to an edge
  /// of their common face.
  TriangleMesh Surface() {
    ForEach(cells_[0], cells_[1], cells_[2], [&](int i, int j, int k) {
      for (int axis = 0; axis < 3; ++axis) {
        std::array<int, 3> next{i, j, k};
        if (++next[axis] == cells_[axis]) continue;
        const std::uint32_t c = Centre(i, j, k);
        const std::uint32_t d = Centre(next[0], next[1], next[2]);
        std::array<std::uint32_t, 4> ring;  // corners of the common face, round the axis
        for (int q = 0; q < 4; ++q) {
          std::array<int, 3> at = next;
          at[(axis + 1) % 3] += q == 1 || q == 2;
          at[(axis + 2) % 3] += q == 2 || q == 3;
          ring[q] = Corner(at[0], at[1], at[2]);
        }
        for (int q = 0; q < 4; ++q) Cut({c, ring[q], ring[(q + 1) % 4], d});
      }
    });
    return std::move(mesh_);
  }

 private:
  template <class Work>
  static void ForEach(int nx, int ny, int nz, Work work) {
    for (int k = 0; k < nz; ++k) {
      for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i) work(i, j, k);
      }
    }
  }
  std::uint32_t Corner(int i, int j, int k) const {
    return std::uint32_t((k * (cells_[1] + 1) + j) * (cells_[0] + 1) + i);
  }
  std::uint32_t Centre(int i, int j, int k) const {
    return std::uint32_t(corners_ + (k * cells_[1] + j) * cells_[0] + i);
  }
  Vec3 CornerAt(int i, int j, int k) const { return origin_ + cell_ * Vec3(i, j, k); }
  Vec3 At(std::uint32_t point) const {
    const bool centre = point >= corners_;
    const std::uint32_t n = centre ? point - std::uint32_t(corners_) : point;
    const int nx = cells_[0] + !centre;
    const int ny = cells_[1] + !centre;
    const int row = int(n) / nx;
    return CornerAt(int(n) % nx, row % ny, row / ny) + Vec3::Constant(centre ? 0.5 * cell_ : 0.0);
  }

  /// Returns the surface's vertex on the edge from an inner to an outer point.
  std::uint32_t VertexOn(std::uint32_t in, std::uint32_t out) {
    const std::uint64_t edge = std::uint64_t{in} << 32 | out;
    const auto [it, fresh] = vertex_.try_emplace(edge, std::uint32_t(mesh_.vertices.size()));
    if (fresh) {
      const double t = std::clamp(values_[in] / (values_[in] - values_[out]), kNearestToEnd,
                                  1.0 - kNearestToEnd);
      mesh_.vertices.push_back((1.0 - t) * At(in) + t * At(out));
    }
    return it->second;
  }

  /// Adds the triangles in a tetrahedron.
  /// @param tet  positively oriented: det(b - a, c - a, d - a) > 0.
  void Cut(std::array<std::uint32_t, 4> tet) {
    // Sort inner points first; every swap reverses the orientation.
    const auto inner = [&](std::uint32_t p) { return values_[p] < 0.0; };
    bool positive = true;
    for (int end = 3; end > 0; --end) {
      for (int i = 0; i < end; ++i) {
        if (inner(tet[i]) || !inner(tet[i + 1])) continue;
        std::swap(tet[i], tet[i + 1]);
        positive = !positive;
      }
    }
    const int count = int(std::count_if(tet.begin(), tet.end(), inner));
    if (!positive) std::swap(tet[count >= 2 ? 0 : 2], tet[count >= 2 ? 1 : 3]);
    const auto& [a, b, c, d] = tet;
    auto& out = mesh_.triangles;
    if (count == 1) {
      out.push_back({VertexOn(a, b), VertexOn(a, c), VertexOn(a, d)});
    } else if (count == 2) {
      const std::uint32_t ac = VertexOn(a, c);
      const std::uint32_t bd = VertexOn(b, d);
      out.push_back({ac, VertexOn(a, d), bd});
      out.push_back({ac, bd, VertexOn(b, c)});
    } else if (count == 3) {
      out.push_back({VertexOn(a, d), VertexOn(b, d), VertexOn(c, d)});
    }
  }

  double cell_;
  Vec3 origin_;
  std::array<int, 3> cells_;
  std::size_t corners_;
  std::vector<double> values_;  ///< at corners, then at centres
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_;
  TriangleMesh mesh_;
};

Vec3 Gradient(const Field& field, const Vec3& p, double step) {
  Vec3 g;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = step * Vec3::Unit(k);
    g[k] = (field(p + e) - field(p - e)) / (2.0 * step);
  }
  return g;
}

/// Returns a nearby point of the surface.  Steps are bounded, because the field is only
/// roughly a distance.
Vec3 OntoSurface(const Field& field, Vec3 p, double cell) {
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Vec3 g = Gradient(field, p, 1e-3 * cell);
    const double square = g.squaredNorm();
    if (!(square > 1e-6)) break;
    Vec3 step = -field(p) / square * g;
    const double length = step.norm();
    if (length > 0.25 * cell) step *= 0.25 * cell / length;
    p += step;
  }
  return p;
}

/// Moves every vertex towards the centre of its neighbours, and then back onto the surface.
void Smooth(const Field& field, double cell, TriangleMesh& mesh) {
  std::vector<Vec3> sum(mesh.vertices.size());
  std::vector<int> count(mesh.vertices.size());
  for (int round = 0; round < kSmoothings; ++round) {
    std::fill(sum.begin(), sum.end(), Vec3::Zero());
    std::fill(count.begin(), count.end(), 0);
    for (const auto& triangle : mesh.triangles) {
      for (int c = 0; c < 3; ++c) {
        sum[triangle[c]] += mesh.vertices[triangle[(c + 1) % 3]];
        ++count[triangle[c]];
      }
    }
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Vec3 middle = sum[v] / count[v];
      mesh.vertices[v] = OntoSurface(field, 0.5 * (mesh.vertices[v] + middle), cell);
    }
  }
}

}  // namespace

double SmoothMin(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * h * h * blend;
}

double SmoothMax(double a, double b, double blend) {
  return -SmoothMin(-a, -b, blend);
}

Field EllipsoidField(const Vec3& centre, const Vec3& semi_axes) {
  return [=](const Vec3& p) {
    const Vec3 q = (p - centre).cwiseQuotient(semi_axes);
    const double slope = q.cwiseQuotient(semi_axes).norm();
    const double k = q.norm();
    return slope > 0.0 ? k * (k - 1.0) / slope : -semi_axes.minCoeff();
  };
}

Field ConeField(const Vec3& a, double radius_a, const Vec3& b, double radius_b) {
  return [=](const Vec3& p) {
    const Vec3 along = b - a;
    const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (p - a - t * along).norm() - (radius_a + t * (radius_b - radius_a));
  };
}

Field RopeField(const std::vector<Vec3>& points, double radius) {
  struct Piece {
    Vec3 from, along;
    double square;
  };
  std::vector<Piece> pieces;
  double longest = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec3 along = points[i + 1] - points[i];
    pieces.push_back({points[i], along, along.squaredNorm()});
    longest = std::max(longest, along.norm());
  }
  return [pieces = std::move(pieces), longest, radius](const Vec3& p) {
    double beginning = 1e300;
    for (const Piece& piece : pieces) {
      beginning = std::min(beginning, (p - piece.from).squaredNorm());
    }
    // No piece with a nearer point begins farther away.
    const double reach = 1.001 * (std::sqrt(beginning) + longest);
    double nearest = 1e300;
    for (const auto& [from, along, square] : pieces) {
      if ((p - from).squaredNorm() > reach * reach) continue;
      const double t = std::clamp((p - from).dot(along) / square, 0.0, 1.0);
      nearest = std::min(nearest, (p - from - t * along).squaredNorm());
    }
    return std::sqrt(nearest) - radius;
  };
}

Field UnionOf(std::vector<Field> fields, double blend) {
  return [fields = std::move(fields), blend](const Vec3& p) {
    double value = fields.front()(p);
    for (std::size_t i = 1; i < fields.size(); ++i) value = SmoothMin(value, fields[i](p), blend);
    return value;
  };
}

Field Without(Field from, Field what, double blend) {
  return [from = std::move(from), what = std::move(what), blend](const Vec3& p) {
    return SmoothMax(from(p), -what(p), blend);
  };
}

TriangleMesh MeshOfField(const Field& field, const Eigen::AlignedBox3d& box, double cell) {
  TriangleMesh mesh = Lattice(field, box, cell).Surface();
  if (mesh.triangles.empty()) throw Error("an implicit surface is empty; enlarge the shape");
  Smooth(field, cell, mesh);
  return mesh;
}

}  // namespace palpate
