#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>

#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere.h"
#include "tests/support/random.h"

// Defects of meshes from scanners, CAD programs and converters, and brute-force tests of whether a
// ball lies inside the clean original.
namespace palpate::test {

inline Vec3 Corner(const TriangleMesh& mesh, std::size_t triangle, int corner) {
  return mesh.vertices[mesh.triangles[triangle][static_cast<std::size_t>(corner)]];
}

inline void TurnTriangle(TriangleMesh& mesh, std::size_t triangle) {
  std::swap(mesh.triangles[triangle][1], mesh.triangles[triangle][2]);
}

/// Gives each triangle three corners of its own, moved by at most `jitter` along each axis.
inline TriangleMesh Unwelded(const TriangleMesh& mesh, double jitter, Random& random) {
  TriangleMesh soup;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (int c = 0; c < 3; ++c) {
      soup.vertices.push_back(Corner(mesh, t, c) + random.InCube(jitter));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// Reverses the winding of a share of the triangles, 0 to 1.
inline void TurnSome(TriangleMesh& mesh, double share, Random& random) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (random.Uniform(0.0, 1.0) < share) TurnTriangle(mesh, t);
  }
}

inline TriangleMesh TurnedOver(TriangleMesh mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) TurnTriangle(mesh, t);
  return mesh;
}

inline TriangleMesh Moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v += by;
  return mesh;
}

/// Combines two meshes into one.
inline TriangleMesh Both(TriangleMesh mesh, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [i, j, k] : other.triangles) {
    mesh.triangles.push_back({first + i, first + j, first + k});
  }
  return mesh;
}

/// Removes the triangles whose centre satisfies the predicate.
template <class Predicate>
TriangleMesh Without(TriangleMesh mesh, Predicate taken) {
  std::erase_if(mesh.triangles, [&](const std::array<std::uint32_t, 3>& t) {
    return taken(Vec3((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0));
  });
  return mesh;
}

/// A sheet of n x n squares over [-half, half]^2, y by the function, facing up (y).
template <class Height>
TriangleMesh MakeSheet(double half, int n, Height height) {
  TriangleMesh sheet;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double x = half * (2.0 * i / n - 1.0), z = half * (2.0 * j / n - 1.0);
      sheet.vertices.push_back({x, height(x, z), z});
    }
  }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      sheet.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      sheet.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  }
  return sheet;
}

/// Returns the mesh as OBJ, with all digits.
/// @param before  number of vertices in the file before these.
inline std::string ObjOf(const TriangleMesh& mesh, std::uint32_t before = 0) {
  std::string text;
  char line[120];
  for (const Vec3& v : mesh.vertices) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", v.x(), v.y(), v.z());
    text += line;
  }
  for (const auto& [i, j, k] : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", before + i + 1, before + j + 1,
                  before + k + 1);
    text += line;
  }
  return text;
}

/// Returns the mesh as text STL, with all digits.
inline std::string TextStlOf(const TriangleMesh& mesh) {
  std::string text = "solid mesh\n";
  char line[120];
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int c = 0; c < 3; ++c) {
      const Vec3 v = Corner(mesh, t, c);
      std::snprintf(line, sizeof line, "vertex %.17g %.17g %.17g\n", v.x(), v.y(), v.z());
      text += line;
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid mesh\n";
}

/// Returns the mesh as PLY, text or binary doubles, with another property before the coordinates.
inline std::string PlyOf(const TriangleMesh& mesh, bool binary) {
  std::string text = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
                     " 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
                     "\nproperty uchar red\nproperty double x\nproperty double y\n"
                     "property double z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  char line[120];
  const auto raw = [&](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const Vec3& v : mesh.vertices) {
    if (binary) {
      text += '\7';
      for (int axis = 0; axis < 3; ++axis) raw(v[axis]);
    } else {
      std::snprintf(line, sizeof line, "7 %.17g %.17g %.17g\n", v.x(), v.y(), v.z());
      text += line;
    }
  }
  for (const auto& corners : mesh.triangles) {
    if (binary) {
      text += '\3';
      for (const std::uint32_t v : corners) raw(static_cast<std::int32_t>(v));
    } else {
      std::snprintf(line, sizeof line, "3 %u %u %u\n", corners[0], corners[1], corners[2]);
      text += line;
    }
  }
  return text;
}

/// Returns the winding number at p, summed over all triangles (Van Oosterom & Strackee 1983).
inline double BruteWinding(const TriangleMesh& mesh, const Vec3& p) {
  double angle = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = Corner(mesh, t, 0) - p, b = Corner(mesh, t, 1) - p, c = Corner(mesh, t, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                              la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * 3.14159265358979323846);
}

/// Returns how far a ball sticks out of a closed, clean mesh; 0 if it lies inside.
inline double SticksOut(const TriangleMesh& clean, const Sphere& ball) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < clean.triangles.size(); ++t) {
    const Vec3 q = NearestOnTriangle(ball.centre, Corner(clean, t, 0), Corner(clean, t, 1),
                                     Corner(clean, t, 2));
    nearest = std::min(nearest, (q - ball.centre).norm());
  }
  const bool inside = BruteWinding(clean, ball.centre) > 0.5;
  return std::max(0.0, ball.radius + (inside ? -nearest : nearest));
}

/// Returns whether any of 26 points of a ball, a thousandth of its radius below its surface, lies
/// outside a closed mesh, which may intersect itself.
inline bool AnyPlaceOutside(const TriangleMesh& mesh, const Sphere& ball) {
  for (int n = 0; n < 27; ++n) {
    if (n == 13) continue;
    const Vec3 way = Vec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1).normalized();
    if (BruteWinding(mesh, ball.centre + 0.999 * ball.radius * way) < 0.5) return true;
  }
  return false;
}

/// Returns whether a closed mesh is solid on only one side of a triangle at a point.
inline bool IsExposed(const TriangleMesh& mesh, std::size_t triangle, const Vec3& at) {
  const Vec3 a = Corner(mesh, triangle, 0);
  const Vec3 area = (Corner(mesh, triangle, 1) - a).cross(Corner(mesh, triangle, 2) - a);
  const Vec3 step = 1e-3 * std::sqrt(area.norm()) * area.normalized();
  return (BruteWinding(mesh, at + step) > 0.5) != (BruteWinding(mesh, at - step) > 0.5);
}

/// Returns the outer triangles of a closed mesh, tested at their centroids and near their corners.
inline TriangleMesh Exposed(const TriangleMesh& mesh) {
  TriangleMesh exposed;
  exposed.vertices = mesh.vertices;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = Corner(mesh, t, 0), b = Corner(mesh, t, 1), c = Corner(mesh, t, 2);
    const Vec3 middle = (a + b + c) / 3.0;
    bool whole = IsExposed(mesh, t, middle);
    for (const Vec3& corner : {a, b, c}) {
      whole = whole && IsExposed(mesh, t, corner + 0.1 * (middle - corner));
    }
    if (whole) exposed.triangles.push_back(mesh.triangles[t]);
  }
  return exposed;
}

}  // namespace palpate::test
