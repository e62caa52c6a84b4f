#include "scenes/shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

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

}  // namespace palpate
