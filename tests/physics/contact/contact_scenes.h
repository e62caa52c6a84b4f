#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {

// Meshes [m] that are simple to describe and hard to touch, and small scenes of them.

/// A square grid of 2 n^2 triangles about the origin: an open height field.  `at(i)` places the
/// grid lines, from -1 to 1.
inline TriangleMesh MakeSheet(int n, double half,
                              const std::function<double(double, double)>& height,
                              const std::function<double(int)>& at = {}) {
  TriangleMesh sheet;
  const auto place = [&](int i) { return half * (at ? at(i) : 2.0 * i / n - 1.0); };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      sheet.vertices.push_back(Vec3(place(i), place(j), height(place(i), place(j))));
    }
  }
  const auto of = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      sheet.triangles.push_back({of(i, j), of(i + 1, j), of(i + 1, j + 1)});
      sheet.triangles.push_back({of(i, j), of(i + 1, j + 1), of(i, j + 1)});
    }
  }
  return sheet;
}

/// The same as the top of a closed block with its base at z = -thickness.
inline TriangleMesh MakeBlock(int n, double half, double thickness,
                              const std::function<double(double, double)>& height,
                              const std::function<double(int)>& at = {}) {
  TriangleMesh block = MakeSheet(n, half, height, at);
  const auto count = static_cast<std::uint32_t>(block.vertices.size());
  for (std::uint32_t v = 0; v < count; ++v) {
    block.vertices.push_back({block.vertices[v].x(), block.vertices[v].y(), -thickness});
  }
  const std::size_t top = block.triangles.size();
  for (std::size_t t = 0; t < top; ++t) {
    const auto [i, j, k] = block.triangles[t];
    block.triangles.push_back({i + count, k + count, j + count});
  }
  const auto of = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  const auto wall = [&](std::uint32_t a, std::uint32_t b) {
    block.triangles.push_back({a, a + count, b + count});
    block.triangles.push_back({a, b + count, b});
  };
  for (int i = 0; i < n; ++i) {
    wall(of(i, 0), of(i + 1, 0));
    wall(of(i + 1, n), of(i, n));
    wall(of(0, i + 1), of(0, i));
    wall(of(n, i), of(n, i + 1));
  }
  return block;
}

inline double Flat(double, double) {
  return 0.0;
}

/// Waves of this amplitude, three along each side.
inline std::function<double(double, double)> Waves(double height, double half) {
  return [=](double x, double y) {
    return height * std::sin(3.0 * M_PI * x / half) * std::cos(3.0 * M_PI * y / half);
  };
}

/// An L of the given size in x and z, its bars half as thick, extruded along y.
inline TriangleMesh MakeL(double size) {
  const double s = size, h = 0.5 * size;
  const Vec3 outline[] = {{0, 0, 0}, {s, 0, 0}, {s, 0, h}, {h, 0, h}, {h, 0, s}, {0, 0, s}};
  TriangleMesh mesh;
  for (const double y : {-h, h}) {
    for (const Vec3& v : outline) mesh.vertices.push_back(v + Vec3(-h, y, -h));
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  for (const auto& [i, j, k] :
       std::vector<std::array<std::uint32_t, 3>>{{0, 3, 1}, {1, 3, 2}, {0, 5, 4}, {0, 4, 3}}) {
    mesh.triangles.push_back({i, k, j});
    mesh.triangles.push_back({i + 6, j + 6, k + 6});
  }
  // From -y, x points right and z up: the outline runs clockwise.
  for (auto& [i, j, k] : mesh.triangles) std::swap(j, k);
  return mesh;
}

/// A box with a fin on an edge of its top: two triangles without thickness, three faces at the
/// foot.
inline TriangleMesh MakeFinnedBox(const Vec3& size, double fin) {
  TriangleMesh mesh = MakeBox(size);
  const auto corner = [&](double x) {
    const Vec3 at(x, 0.5 * size.y(), 0.5 * size.z());
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if ((mesh.vertices[v] - at).norm() < 1e-12) return v;
    }
    return 0u;
  };
  const std::uint32_t a = corner(-0.5 * size.x()), b = corner(0.5 * size.x());
  const auto c = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(mesh.vertices[a] + Vec3(0.0, 0.0, fin));
  mesh.vertices.push_back(mesh.vertices[b] + Vec3(0.0, 0.0, fin));
  mesh.triangles.push_back({a, b, c + 1});
  mesh.triangles.push_back({a, c + 1, c});
  return mesh;
}

/// An open sheet, crumpled so that it folds over and passes through itself, as scans do; some
/// triangles are missing, some duplicated.
inline TriangleMesh MakeCrumpled(int n, double half, double fold, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh sheet = MakeSheet(n, half, Flat);
  for (Vec3& v : sheet.vertices) v += random.InCube(fold);
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (const auto& triangle : sheet.triangles) {
    const int what = random.Below(20);
    if (what > 0) kept.push_back(triangle);
    if (what == 1) kept.push_back({triangle[1], triangle[0], triangle[2]});
  }
  sheet.triangles = kept;
  return sheet;
}

/// Grid lines that make needles: gaps from a hundred thousandth of the side to a fifth.
inline double Crowded(int i) {
  static constexpr double kAt[] = {-1.0,    -0.6,   -0.59999, -0.2,   -0.1999, 0.0,
                                   0.00001, 0.0002, 0.25,     0.2501, 0.7,     1.0};
  return kAt[i];
}
inline constexpr int kCrowded = 11;

inline TriangleMesh Scaled(TriangleMesh mesh, double by) {
  for (Vec3& v : mesh.vertices) v *= by;
  return mesh;
}

}  // namespace palpate::test
