#include "tests/support/sharp_bodies.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

using Outline = std::vector<Vec3>;

/// Returns twice the signed area of a triangle in the plane, positive if counter-clockwise.
double Turn(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a).z();
}

/// Triangulates a simple polygon by ear clipping.
std::vector<std::array<std::uint32_t, 3>> Triangulated(std::span<const Vec3> outline) {
  std::vector<std::uint32_t> left(outline.size());
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto is_ear = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Vec3 &A = outline[a], &B = outline[b], &C = outline[c];
    if (!(Turn(A, B, C) > 0.0)) return false;
    return std::none_of(left.begin(), left.end(), [&](std::uint32_t i) {
      const Vec3& P = outline[i];
      return i != a && i != b && i != c && Turn(A, B, P) >= 0.0 && Turn(B, C, P) >= 0.0 &&
             Turn(C, A, P) >= 0.0;
    });
  };
  while (left.size() > 2) {
    const std::size_t n = left.size();
    std::size_t k = 0;
    while (k < n && !is_ear(left[k], left[(k + 1) % n], left[(k + 2) % n])) ++k;
    if (k == n) break;  // not a simple polygon
    triangles.push_back({left[k], left[(k + 1) % n], left[(k + 2) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>((k + 1) % n));
  }
  return triangles;
}

void CentreBox(TriangleMesh& mesh) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  for (Vec3& v : mesh.vertices) v -= 0.5 * (low + high);
}

/// Makes a side of a plate, from its first corner up to the next side, with its notches.
void AddSide(Outline& outline, const Vec3& from, const Vec3& to, Random& random) {
  const Vec3 along = (to - from).normalized(), inward(-along.y(), along.x(), 0.0);
  // No notch is nearer to a corner than notches are deep, so that those of two sides do not meet.
  constexpr double kDeepest = 0.006, kRim = 1.2 * kDeepest;
  const int notches = 2 + random.Below(2);
  const double part = ((to - from).norm() - 2.0 * kRim) / notches;
  const auto add = [&](double s, double depth) {
    outline.push_back(from + s * along + depth * inward);
  };
  add(0.0, 0.0);
  for (int i = 0; i < notches; ++i) {
    const double middle = kRim + (i + random.Uniform(0.45, 0.55)) * part;
    const double half = random.Uniform(0.1, 0.25) * part,
                 depth = random.Uniform(0.5, 1.0) * kDeepest;
    add(middle - half, 0.0);
    if (random.Below(2) == 0) {
      add(middle, depth);
    } else {
      add(middle - half, depth);
      add(middle + half, depth);
    }
    add(middle + half, 0.0);
  }
}

}  // namespace

TriangleMesh Extruded(std::span<const Vec3> outline, double thickness) {
  const auto n = static_cast<std::uint32_t>(outline.size());
  TriangleMesh mesh;
  for (const double z : {-0.5 * thickness, 0.5 * thickness}) {
    for (const Vec3& v : outline) mesh.vertices.push_back({v.x(), v.y(), z});
  }
  for (const auto& [a, b, c] : Triangulated(outline)) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + n, b + n, c + n});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, j + n});
    mesh.triangles.push_back({i, j + n, i + n});
  }
  CentreBox(mesh);
  return mesh;
}

TriangleMesh MakeComb(std::uint64_t seed) {
  Random random(seed);
  const int teeth = 4 + random.Below(5);
  const double tooth = random.Uniform(0.0015, 0.004), gap = tooth * random.Uniform(0.8, 1.6);
  const double back = random.Uniform(0.004, 0.008), length = random.Uniform(0.008, 0.02);
  const double slant = random.Uniform(0.0, 0.4) * tooth;  // at the tip, of each flank
  const double rim = 0.001, width = teeth * tooth + (teeth - 1) * gap;
  Outline outline{{-rim, 0.0, 0.0}, {width + rim, 0.0, 0.0}, {width + rim, back, 0.0}};
  for (int i = teeth - 1; i >= 0; --i) {
    const double left = i * (tooth + gap), right = left + tooth;
    outline.push_back({right, back, 0.0});
    outline.push_back({right - slant, back + length, 0.0});
    outline.push_back({left + slant, back + length, 0.0});
    outline.push_back({left, back, 0.0});
  }
  outline.push_back({-rim, back, 0.0});
  return Extruded(outline, random.Uniform(0.005, 0.015));
}

TriangleMesh MakeGear(std::uint64_t seed) {
  Random random(seed);
  const int teeth = 8 + random.Below(13);
  const double root = random.Uniform(0.012, 0.02), tip = root + random.Uniform(0.003, 0.006);
  const double tip_share = random.Uniform(0.15, 0.35), root_share = random.Uniform(0.4, 0.6);
  Outline outline;
  for (int i = 0; i < teeth; ++i) {
    const auto add = [&](double radius, double share) {
      const double angle = 2.0 * M_PI * (i + share) / teeth;
      outline.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
    };
    add(root, -0.5 * root_share);
    add(tip, -0.5 * tip_share);
    add(tip, 0.5 * tip_share);
    add(root, 0.5 * root_share);
  }
  return Extruded(outline, random.Uniform(0.006, 0.015));
}

TriangleMesh MakeNotchedPlate(std::uint64_t seed) {
  Random random(seed);
  const double x = random.Uniform(0.03, 0.06), y = random.Uniform(0.025, 0.04);
  const Vec3 corners[] = {{0.0, 0.0, 0.0}, {x, 0.0, 0.0}, {x, y, 0.0}, {0.0, y, 0.0}};
  Outline outline;
  for (std::size_t i = 0; i < 4; ++i) AddSide(outline, corners[i], corners[(i + 1) % 4], random);
  return Extruded(outline, random.Uniform(0.001, 0.003));
}

TriangleMesh MakeDie(std::uint64_t seed) {
  Random random(seed);
  // Each face is 7 x 7 cells, those of pits 2 or 3 cells apart.
  constexpr int kCells = 7;
  const double half = 0.5 * random.Uniform(0.018, 0.03), cell = 2.0 * half / kCells;
  const double depth = cell * random.Uniform(0.3, 1.0);
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> corners;
  const auto add = [&](const Vec3& at) {
    mesh.vertices.push_back(at);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  for (int face = 0; face < 6; ++face) {
    const std::size_t axis = static_cast<std::size_t>(face / 2);
    const bool high = face % 2 == 1;
    const auto corner = [&](int i, int j) {
      std::array<int, 3> at{};
      at[axis] = high ? kCells : 0;
      at[(axis + 1) % 3] = high ? i : j;  // so that (i, j) runs counter-clockwise seen from outside
      at[(axis + 2) % 3] = high ? j : i;
      const auto [found, made] = corners.try_emplace(at, 0);
      if (made) found->second = add(cell * Vec3(at[0], at[1], at[2]) - Vec3::Constant(half));
      return found->second;
    };
    Vec3 inward = Vec3::Zero();
    inward[static_cast<Eigen::Index>(axis)] = high ? -depth : depth;
    const int pits = 1 + random.Below(6);
    const auto is_pit = [&](int i, int j) {
      static constexpr int kPlaces[6][2] = {{1, 1}, {5, 5}, {1, 5}, {5, 1}, {3, 1}, {3, 5}};
      return std::any_of(kPlaces, kPlaces + pits,
                         [&](const int* place) { return place[0] == i && place[1] == j; });
    };
    for (int i = 0; i < kCells; ++i) {
      for (int j = 0; j < kCells; ++j) {
        const std::array<std::uint32_t, 4> ring{corner(i, j), corner(i + 1, j),
                                                corner(i + 1, j + 1), corner(i, j + 1)};
        if (!is_pit(i, j)) {
          mesh.triangles.push_back({ring[0], ring[1], ring[2]});
          mesh.triangles.push_back({ring[0], ring[2], ring[3]});
          continue;
        }
        const Vec3 middle = 0.5 * (mesh.vertices[ring[0]] + mesh.vertices[ring[2]]);
        const std::uint32_t foot = add(middle + inward);
        for (std::size_t k = 0; k < 4; ++k) {
          mesh.triangles.push_back({ring[k], ring[(k + 1) % 4], foot});
        }
      }
    }
  }
  return mesh;
}

TriangleMesh MakeTerraced(double radius, std::size_t triangles, std::uint64_t seed) {
  Random random(seed);
  Vec3 along[6];
  double from[6];
  for (int i = 0; i < 6; ++i) {
    along[i] = random.InCube(5.0);
    from[i] = random.Uniform(0.0, 2.0 * M_PI);
  }
  TriangleMesh ball = MakeSphere(1.0, triangles);
  for (Vec3& v : ball.vertices) {
    double height = 0.0;
    for (int i = 0; i < 6; ++i) height += std::sin(along[i].dot(v) + from[i]);
    v *= radius * (1.0 + 0.125 * std::round(height));
  }
  return ball;
}

std::optional<Scene> MakeSharpScene(std::string_view name) {
  const std::string_view kind = name.substr(0, name.find(':'));
  std::uint64_t seed = 1;
  if (kind.size() < name.size()) {
    const char* const end = name.data() + name.size();
    const auto [rest, bad] = std::from_chars(name.data() + kind.size() + 1, end, seed);
    if (bad != std::errc() || rest != end) return {};
  }
  // Tool and object are not the same.
  const std::uint64_t tool = 2 * seed, object = 2 * seed + 1;
  const auto against = [&](Body of_tool, TriangleMesh of_object) {
    Scene made;
    made.name = std::string(name);
    made.tools.push_back(std::move(of_tool));
    made.objects.push_back(MakeSolidBody("object", std::move(of_object)));
    return made;
  };
  const auto scene = [&](TriangleMesh of_tool, TriangleMesh of_object) {
    return against(MakeSolidBody("tool", std::move(of_tool)), std::move(of_object));
  };
  if (kind == kSharpScenes[0]) return scene(MakeComb(tool), MakeComb(object));
  if (kind == kSharpScenes[1]) return scene(MakeGear(tool), MakeGear(object));
  if (kind == kSharpScenes[2]) return scene(MakeNotchedPlate(tool), MakeNotchedPlate(object));
  if (kind == kSharpScenes[3]) return scene(MakeDie(tool), MakeDie(object));
  if (kind == kSharpScenes[4]) return scene(MakeGear(tool), MakeComb(object));
  if (kind == kSharpScenes[5]) return against(BallBody(0.0045), MakeTerraced(0.04, 5120, object));
  return {};
}

}  // namespace palpate::test
