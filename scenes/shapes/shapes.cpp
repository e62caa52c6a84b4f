#include "scenes/shapes/shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "common/math/elementary.h"
#include "scenes/shapes/swept_mesh.h"

namespace palpate {

TriangleMesh MakeBox(const Vec3& size) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {  // bit i of the corner: the sign of coordinate i
    const Vec3 sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    mesh.vertices.push_back(sign.cwiseProduct(size));
  }
  static constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& [a, b, c, d] : kFaces) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

TriangleMesh MakeEllipsoid(const Vec3& semi_axes, std::size_t triangles) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleMesh mesh;
  for (const double one : {-1.0, 1.0}) {
    for (const double golden : {-g, g}) {
      mesh.vertices.emplace_back(0.0, one, golden);
      mesh.vertices.emplace_back(one, golden, 0.0);
      mesh.vertices.emplace_back(golden, 0.0, one);
    }
  }
  // The faces are the triples of neighbours; edges have length 2.
  const auto neighbours = [&](std::uint32_t a, std::uint32_t b) {
    return std::abs((mesh.vertices[a] - mesh.vertices[b]).norm() - 2.0) < 1e-9;
  };
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!neighbours(a, b) || !neighbours(b, c) || !neighbours(c, a)) continue;
        const Vec3& v = mesh.vertices[a];
        const bool outward = v.dot((mesh.vertices[b] - v).cross(mesh.vertices[c] - v)) > 0.0;
        mesh.triangles.push_back(outward ? std::array{a, b, c} : std::array{a, c, b});
      }
    }
  }
  for (Vec3& v : mesh.vertices) v.normalize();
  while (mesh.triangles.size() < triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, made] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (made) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(semi_axes);
  return mesh;
}

TriangleMesh MakeSphere(double radius, std::size_t triangles) {
  return MakeEllipsoid(Vec3::Constant(radius), triangles);
}

TriangleMesh MakeBentPipe(double inner_radius, double wall, double length, double bend) {
  const int steps = 2 + static_cast<int>(bend / 0.1);
  std::vector<Vec3> curve;
  for (int i = 0; i <= steps; ++i) {
    const double s = double(i) / steps;
    const double a = bend * s;
    // sin(a)/a and (1 - cos a)/a, also valid for straight pipes.
    const double along = a > 1e-9 ? Sin(a) / a : 1.0;
    const double aside = a > 1e-9 ? (1.0 - Cos(a)) / a : 0.0;
    curve.emplace_back(length * s * aside, 0.0, length * s * along);
  }
  return MakePipe(curve, inner_radius, wall, 48);
}

TriangleMesh MakeMould(bool mould, double radius, double depth, double wave, double thickness) {
  // The surface where both meet, over a square that is bent to a disc.
  constexpr int kSteps = 56;
  const auto height = [&](double x, double z) {
    const double e = (x * x + z * z) / (radius * radius);
    const double fade = 1.0 - e;  // the rim is flat
    return -depth * fade + wave * fade * Sin(22.0 * x / radius) * Sin(22.0 * z / radius);
  };
  const double flat = mould ? -depth - thickness : thickness;
  TriangleMesh mesh;
  const auto add_layer = [&](bool shaped) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i <= kSteps; ++i) {
      for (int k = 0; k <= kSteps; ++k) {
        const double u = 2.0 * i / kSteps - 1.0;
        const double v = 2.0 * k / kSteps - 1.0;
        const double x = radius * u * std::sqrt(1.0 - 0.5 * v * v);
        const double z = radius * v * std::sqrt(1.0 - 0.5 * u * u);
        mesh.vertices.emplace_back(x, shaped ? height(x, z) : flat, z);
      }
    }
    return first;
  };
  const auto add_triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, bool keep) {
    mesh.triangles.push_back(keep ? std::array{a, b, c} : std::array{a, c, b});
  };
  constexpr std::uint32_t kRow = kSteps + 1;
  const std::uint32_t shaped = add_layer(true);
  const std::uint32_t plain = add_layer(false);
  for (const std::uint32_t layer : {shaped, plain}) {
    const bool up = (layer == shaped) == mould;  // x cross z is -y
    for (std::uint32_t i = 0; i < kSteps; ++i) {
      for (std::uint32_t k = 0; k < kSteps; ++k) {
        const std::uint32_t a = layer + i * kRow + k;
        add_triangle(a, a + kRow + 1, a + kRow, up);
        add_triangle(a, a + 1, a + kRow + 1, up);
      }
    }
  }
  // The wall between both: the rim's vertices in turn, counter-clockwise seen from -y.
  std::vector<std::uint32_t> rim;
  for (std::uint32_t s = 0; s < kSteps; ++s) rim.push_back(s * kRow);
  for (std::uint32_t s = 0; s < kSteps; ++s) rim.push_back(kSteps * kRow + s);
  for (std::uint32_t s = kSteps; s > 0; --s) rim.push_back(s * kRow + kSteps);
  for (std::uint32_t s = kSteps; s > 0; --s) rim.push_back(s);
  for (std::size_t s = 0; s < rim.size(); ++s) {
    const std::uint32_t a = rim[s];
    const std::uint32_t b = rim[(s + 1) % rim.size()];
    add_triangle(shaped + a, shaped + b, plain + b, mould);
    add_triangle(shaped + a, plain + b, plain + a, mould);
  }
  return mesh;
}

}  // namespace palpate
