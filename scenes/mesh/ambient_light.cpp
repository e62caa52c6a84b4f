#include "scenes/mesh/ambient_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "common/math/elementary.h"

namespace palpate {
namespace {

constexpr int kDirections = 96;
constexpr int kMapSize = 700;
// Shares of the scene's radius.  A vertex is examined from a little above its surface, so that
// neighbouring triangles, drawn in pixels, do not hide it.
constexpr double kLift = 4e-3;
constexpr double kBias = 2e-3;

struct LitBody {
  std::vector<Vec3> vertices, normals;  ///< W
  std::vector<double> seen, most;
};

LitBody InWorld(const Body& body) {
  LitBody lit;
  for (const Vec3& v : body.mesh.vertices) lit.vertices.push_back(body.X_WB.p + body.X_WB.q * v);
  lit.normals.assign(lit.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : body.mesh.triangles) {
    const Vec3 area = (lit.vertices[b] - lit.vertices[a]).cross(lit.vertices[c] - lit.vertices[a]);
    for (const std::uint32_t v : {a, b, c}) lit.normals[v] += area;
  }
  for (Vec3& n : lit.normals) n.normalize();
  lit.seen.assign(lit.vertices.size(), 0.0);
  lit.most.assign(lit.vertices.size(), 0.0);
  return lit;
}

/// The heights, towards the light, of the surface nearest to it.
class DepthMap {
 public:
  /// @param centre, radius  of a ball round everything drawn.   @param towards  the light, unit.
  DepthMap(const Vec3& centre, double radius, const Vec3& towards)
      : centre_(centre),
        to_pixels_(0.5 * kMapSize / radius),
        towards_(towards),
        right_(towards.unitOrthogonal()),
        up_(towards.cross(right_)),
        heights_(std::size_t{kMapSize} * kMapSize, -std::numeric_limits<double>::infinity()) {}

  /// Returns column and row [pixels], and height [m].
  Vec3 At(const Vec3& p) const {
    const Vec3 d = p - centre_;
    return {to_pixels_ * right_.dot(d) + 0.5 * kMapSize, to_pixels_ * up_.dot(d) + 0.5 * kMapSize,
            towards_.dot(d)};
  }

  void Draw(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0) return;
    const auto first = [](double x) { return std::clamp(int(std::ceil(x - 0.5)), 0, kMapSize); };
    const int row_end = first(std::max({a.y(), b.y(), c.y()}));
    const int column_begin = first(std::min({a.x(), b.x(), c.x()}));
    const int column_end = first(std::max({a.x(), b.x(), c.x()}));
    for (int row = first(std::min({a.y(), b.y(), c.y()})); row < row_end; ++row) {
      for (int column = column_begin; column < column_end; ++column) {
        const double x = column + 0.5;
        const double y = row + 0.5;
        const double u = ((b.x() - x) * (c.y() - y) - (b.y() - y) * (c.x() - x)) / area;
        const double v = ((c.x() - x) * (a.y() - y) - (c.y() - y) * (a.x() - x)) / area;
        if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
        double& height = heights_[std::size_t(row) * kMapSize + column];
        height = std::max(height, u * a.z() + v * b.z() + (1.0 - u - v) * c.z());
      }
    }
  }

  double HeightAt(const Vec3& pixel) const {
    const auto inside = [](double x) { return std::clamp(int(x), 0, kMapSize - 1); };
    return heights_[std::size_t(inside(pixel.y())) * kMapSize + inside(pixel.x())];
  }

 private:
  Vec3 centre_;
  double to_pixels_;
  Vec3 towards_, right_, up_;
  std::vector<double> heights_;
};

/// Returns whether the surface under the body will become visible.  A single body that burs cut
/// still shades itself.
bool ShadesNothing(const Body& body, std::size_t objects) {
  return body.grid && objects > 1;
}

/// Returns one of many directions spread evenly over the sphere: a spiral (Fibonacci).
Vec3 Direction(int i) {
  const double y = 1.0 - (2.0 * i + 1.0) / kDirections;
  const double turn = i * 3.14159265358979323846 * (3.0 - std::sqrt(5.0));
  const double level = std::sqrt(1.0 - y * y);
  return {level * Cos(turn), y, level * Sin(turn)};
}

}  // namespace

void LightObjects(std::vector<Body>& objects) {
  std::vector<LitBody> bodies;
  Eigen::AlignedBox3d box;
  for (const Body& object : objects) {
    bodies.push_back(InWorld(object));
    for (const Vec3& v : bodies.back().vertices) box.extend(v);
  }
  const double radius = 0.5 * box.diagonal().norm();
  for (int i = 0; i < kDirections; ++i) {
    const Vec3 towards = Direction(i);
    DepthMap map(box.center(), radius, towards);
    for (std::size_t o = 0; o < objects.size(); ++o) {
      if (ShadesNothing(objects[o], objects.size())) continue;
      std::vector<Vec3> pixels;
      for (const Vec3& v : bodies[o].vertices) pixels.push_back(map.At(v));
      for (const auto& [a, b, c] : objects[o].mesh.triangles)
        map.Draw(pixels[a], pixels[b], pixels[c]);
    }
    for (LitBody& body : bodies) {
      for (std::size_t v = 0; v < body.vertices.size(); ++v) {
        const double facing = body.normals[v].dot(towards);
        if (!(facing > 0.0)) continue;
        const Vec3 pixel = map.At(body.vertices[v] + kLift * radius * body.normals[v]);
        body.most[v] += facing;
        if (pixel.z() >= map.HeightAt(pixel) - kBias * radius) body.seen[v] += facing;
      }
    }
  }
  for (std::size_t o = 0; o < objects.size(); ++o) {
    objects[o].ambient.clear();
    for (std::size_t v = 0; v < bodies[o].seen.size(); ++v) {
      const double share = bodies[o].seen[v] / std::max(bodies[o].most[v], 1e-9);
      objects[o].ambient.push_back(static_cast<std::uint8_t>(std::lround(255.0 * share)));
    }
  }
}

}  // namespace palpate
