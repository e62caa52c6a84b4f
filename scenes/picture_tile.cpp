#include "scenes/picture_tile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

constexpr double kFill = 0.78;  // diameter of the mesh, as a share of a tile's side

std::pair<int, int> Span(int size, double low, double high) {
  return {std::clamp(static_cast<int>(low), 0, size),
          std::clamp(static_cast<int>(high), -1, size - 1)};
}

}  // namespace

Tile::Tile(const Vec3& centre, double radius)
    : centre_(centre),
      scale_(0.5 * kFill * kFine / radius),
      depth_(kFine * kFine, -std::numeric_limits<double>::infinity()),
      colour_(kFine * kFine) {
  for (int y = 0; y < kFine; ++y) {
    const Colour sky = Colour(0.93, 0.95, 0.97) - 0.18 * y / kFine;
    std::fill_n(colour_.begin() + y * kFine, kFine, sky);
  }
  const Vec3 to_eye = Vec3(0.45, 0.3, 1.0).normalized();
  const Vec3 right = Vec3::UnitY().cross(to_eye).normalized();
  view_ << right.transpose(), to_eye.cross(right).transpose(), to_eye.transpose();
}

// Few meshes reach the corners of their boxes, so a smaller ball suffices.
Tile::Tile(const TriangleMesh& mesh)
    : Tile(BoxOf(mesh).center(), 0.5 * 0.85 * BoxOf(mesh).diagonal().norm()) {}

void Tile::Draw(const TriangleMesh& mesh, const Colour& colour) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3& a = mesh.vertices[i];
    const Vec3 n = (mesh.vertices[j] - a).cross(mesh.vertices[k] - a);
    for (std::uint32_t v : {i, j, k}) normals[v] += n;
  }
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3, 3> p;
    std::array<Vec3, 3> n;
    const Vec3& a = mesh.vertices[triangle[0]];
    const Vec3 facet =
        (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).normalized();
    for (int c = 0; c < 3; ++c) {
      p[c] = ToPixels(mesh.vertices[triangle[c]]);
      // Smooth shading, but flat at edges of more than about 40 degrees.
      const Vec3 smooth = normals[triangle[c]].normalized();
      n[c] = view_ * (smooth.dot(facet) > 0.77 ? smooth : facet);
    }
    DrawTriangle(p, n, colour);
  }
}

void Tile::DrawSphere(const Vec3& centre, double radius, const Colour& colour) {
  const Vec3 c = ToPixels(centre);
  const double r = radius * scale_;
  const auto [x0, x1] = Span(kFine, c.x() - r, c.x() + r);
  const auto [y0, y1] = Span(kFine, c.y() - r, c.y() + r);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double dx = x + 0.5 - c.x();
      const double dy = y + 0.5 - c.y();
      const double dz2 = r * r - dx * dx - dy * dy;
      if (dz2 < 0.0) continue;
      const double dz = std::sqrt(dz2);
      Put(x, y, c.z() + dz, Vec3(dx, -dy, dz) / r, colour);
    }
  }
}

void Tile::ShadeHollows() {
  std::vector<double> light(colour_.size(), 1.0);
  for (int y = 0; y < kFine; ++y) {
    for (int x = 0; x < kFine; ++x) {
      const double z = depth_[y * kFine + x];
      if (!std::isfinite(z)) continue;
      double hidden = 0.0;
      for (int k = 0; k < 24; ++k) {
        // A spiral of the golden angle, 2.4 rad.
        const double reach = 0.045 * kFine * std::sqrt((k + 0.5) / 24.0);
        const int sx = x + static_cast<int>(reach * std::cos(2.4 * k));
        const int sy = y + static_cast<int>(reach * std::sin(2.4 * k));
        if (sx < 0 || sy < 0 || sx >= kFine || sy >= kFine) continue;
        const double above = depth_[sy * kFine + sx] - z - 0.3 * reach;
        if (above > 0.0 && above < 4.0 * reach + 20.0) hidden += 1.0;
      }
      light[y * kFine + x] = 1.0 - 0.55 * hidden / 24.0;
    }
  }
  for (std::size_t i = 0; i < light.size(); ++i) colour_[i] *= light[i];
}

Colour Tile::At(int x, int y) const {
  Colour sum = Colour::Zero();
  for (int dy = 0; dy < kOversampling; ++dy) {
    for (int dx = 0; dx < kOversampling; ++dx) {
      sum += colour_[(y * kOversampling + dy) * kFine + x * kOversampling + dx];
    }
  }
  return sum / (kOversampling * kOversampling);
}

Vec3 Tile::ToPixels(const Vec3& p) const {
  const Vec3 v = scale_ * (view_ * (p - centre_));
  return {0.5 * kFine + v.x(), 0.5 * kFine - v.y(), v.z()};
}

void Tile::DrawTriangle(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& n,
                        const Colour& colour) {
  const auto [x0, x1] = Span(kFine, std::min({p[0].x(), p[1].x(), p[2].x()}),
                             std::max({p[0].x(), p[1].x(), p[2].x()}));
  const auto [y0, y1] = Span(kFine, std::min({p[0].y(), p[1].y(), p[2].y()}),
                             std::max({p[0].y(), p[1].y(), p[2].y()}));
  const auto cross = [](const Vec3& a, const Vec3& b, double x, double y) {
    return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
  };
  const double area = cross(p[0], p[1], p[2].x(), p[2].y());
  if (area == 0.0) return;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double u = cross(p[1], p[2], x + 0.5, y + 0.5) / area;
      const double v = cross(p[2], p[0], x + 0.5, y + 0.5) / area;
      const double w = 1.0 - u - v;
      if (u < 0.0 || v < 0.0 || w < 0.0) continue;
      Vec3 normal = (u * n[0] + v * n[1] + w * n[2]).normalized();
      if (normal.z() < 0.0) normal = -normal;  // back of an open mesh
      Put(x, y, u * p[0].z() + v * p[1].z() + w * p[2].z(), normal, colour);
    }
  }
}

void Tile::Put(int x, int y, double z, const Vec3& normal, const Colour& colour) {
  double& depth = depth_[y * kFine + x];
  if (z <= depth) return;
  depth = z;
  static const Vec3 kKey = Vec3(-0.5, 0.65, 0.6).normalized();
  static const Vec3 kShine = (kKey + Vec3::UnitZ()).normalized();
  const double key = std::max(0.0, normal.dot(kKey));
  const double sky = 0.5 + 0.5 * normal.y();
  const double shine = std::pow(std::max(0.0, normal.dot(kShine)), 40.0);
  colour_[y * kFine + x] = colour * (0.22 + 0.28 * sky + 0.62 * key) + 0.12 * shine;
}

}  // namespace palpate
