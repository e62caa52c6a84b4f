#include "scenes/shapes/swept_mesh.h"

#include <cmath>
#include <cstdint>

#include "common/math/elementary.h"
#include "common/math/rotation.h"

namespace palpate {
namespace {

constexpr double kTurn = 6.283185307179586;

/// Makes rings round the curve's points, in a frame that does not twist.
class Sweep {
 public:
  Sweep(const std::vector<Vec3>& curve, int sides) : curve_(curve), sides_(std::uint32_t(sides)) {
    Vec3 previous = Tangent(0);
    Vec3 u = previous.unitOrthogonal();
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Vec3 t = Tangent(i);
      u = RotationBetween(previous, t) * u;
      u = (u - u.dot(t) * t).normalized();
      u_.push_back(u);
      v_.push_back(t.cross(u));
      previous = t;
    }
  }

  /// Makes rings round points of one axis, in any order.
  Sweep(const std::vector<Vec3>& curve, int sides, const Vec3& axis)
      : curve_(curve),
        sides_(std::uint32_t(sides)),
        u_(curve.size(), axis.unitOrthogonal()),
        v_(curve.size(), axis.cross(u_[0])) {}

  /// Returns the first of the ring's vertices.
  std::uint32_t AddRing(std::size_t point, double radius) {
    const auto first = std::uint32_t(mesh.vertices.size());
    for (std::uint32_t s = 0; s < sides_; ++s) {
      const double a = kTurn * s / sides_;
      mesh.vertices.push_back(curve_[point] + radius * (Cos(a) * u_[point] + Sin(a) * v_[point]));
    }
    return first;
  }
  /// Adds a band between two rings; seen from outside, the second lies ahead along the curve.
  void Join(std::uint32_t back, std::uint32_t ahead) {
    for (std::uint32_t s = 0; s < sides_; ++s) {
      const std::uint32_t n = (s + 1) % sides_;
      mesh.triangles.push_back({back + s, back + n, ahead + n});
      mesh.triangles.push_back({back + s, ahead + n, ahead + s});
    }
  }
  void Close(std::uint32_t ring, std::size_t point, bool at_end) {
    const auto middle = std::uint32_t(mesh.vertices.size());
    mesh.vertices.push_back(curve_[point]);
    for (std::uint32_t s = 0; s < sides_; ++s) {
      const std::uint32_t n = (s + 1) % sides_;
      if (at_end) {
        mesh.triangles.push_back({middle, ring + s, ring + n});
      } else {
        mesh.triangles.push_back({middle, ring + n, ring + s});
      }
    }
  }

  /// Makes rings of these radii, joins them, and closes the first and the last one.
  TriangleMesh Closed(const std::vector<double>& radii) {
    std::uint32_t ring = AddRing(0, radii[0]);
    Close(ring, 0, false);
    for (std::size_t i = 1; i < curve_.size(); ++i) {
      const std::uint32_t next = AddRing(i, radii[i]);
      Join(ring, next);
      ring = next;
    }
    Close(ring, curve_.size() - 1, true);
    return std::move(mesh);
  }

  TriangleMesh mesh;

 private:
  Vec3 Tangent(std::size_t i) const {
    const std::size_t a = i == 0 ? 0 : i - 1;
    const std::size_t b = i + 1 == curve_.size() ? i : i + 1;
    return (curve_[b] - curve_[a]).normalized();
  }

  const std::vector<Vec3>& curve_;
  std::uint32_t sides_;
  std::vector<Vec3> u_, v_;
};

}  // namespace

TriangleMesh MakeRod(const std::vector<Vec3>& curve, const std::vector<double>& radii, int sides) {
  return Sweep(curve, sides).Closed(radii);
}

TriangleMesh MakeTurned(const std::vector<std::array<double, 2>>& curve, int sides) {
  std::vector<Vec3> axis;
  std::vector<double> radii;
  for (const auto& [rho, y] : curve) {
    axis.emplace_back(0.0, y, 0.0);
    radii.push_back(rho);
  }
  return Sweep(axis, sides, Vec3::UnitY()).Closed(radii);
}

TriangleMesh MakePipe(const std::vector<Vec3>& curve, double inner_radius, double wall, int sides) {
  Sweep sweep(curve, sides);
  const std::uint32_t first_inner = sweep.AddRing(0, inner_radius);
  const std::uint32_t first_outer = sweep.AddRing(0, inner_radius + wall);
  sweep.Join(first_inner, first_outer);  // the front ring: seen from in front of the pipe
  std::uint32_t inner = first_inner;
  std::uint32_t outer = first_outer;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const std::uint32_t next_inner = sweep.AddRing(i, inner_radius);
    const std::uint32_t next_outer = sweep.AddRing(i, inner_radius + wall);
    sweep.Join(outer, next_outer);
    sweep.Join(next_inner, inner);
    inner = next_inner;
    outer = next_outer;
  }
  sweep.Join(outer, inner);
  return std::move(sweep.mesh);
}

}  // namespace palpate
