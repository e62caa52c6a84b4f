#include "scenes/mesh/curved_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "scenes/shapes/implicit_mesh.h"
#include "scenes/shapes/shapes.h"
#include "scenes/shapes/swept_mesh.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/triangle_overlap.h"

namespace palpate {
namespace {

constexpr std::size_t kPlenty = 4'000'000;
const Vec3 kAxes(0.04, 0.025, 0.03);

CurvedMesh Refine(const TriangleMesh& mesh, double tolerance) {
  return RefineCurved(mesh, {tolerance, kPlenty});
}

bool Same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.triangles == b.triangles && a.vertices.size() == b.vertices.size() &&
         std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vec3)) == 0;
}

/// Distance of a point to the ellipsoid, to first order.
double Off(const Vec3& p, const Vec3& axes) {
  const Vec3 gradient = p.cwiseQuotient(axes.cwiseProduct(axes));
  return (p.cwiseQuotient(axes).norm() - 1.0) / gradient.norm();
}

/// Distances to the ellipsoid over all triangles, and the angles between their normals.
struct Errors {
  double max = 0.0, rms = 0.0, slope = 0.0;
};
Errors ErrorsOf(const TriangleMesh& mesh, const Vec3& axes) {
  Errors e;
  double area = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    const Vec3 across = (b - a).cross(c - a);
    for (int u = 0; u <= 4; ++u) {
      for (int v = 0; u + v <= 4; ++v) {
        const Vec3 p = a + 0.25 * u * (b - a) + 0.25 * v * (c - a);
        const double off = Off(p, axes);
        const Vec3 truth = p.cwiseQuotient(axes.cwiseProduct(axes)).normalized();
        e.max = std::max(e.max, std::abs(off));
        e.rms += across.norm() * off * off;
        e.slope += across.norm() * across.normalized().cross(truth).squaredNorm();
        area += across.norm();
      }
    }
  }
  e.rms = std::sqrt(e.rms / area);
  e.slope = std::sqrt(e.slope / area);
  return e;
}

/// Edges by their number of triangles, and Euler's characteristic.
struct Topology {
  std::map<std::size_t, std::size_t> open;  ///< edges of other than two triangles, by their number
  std::ptrdiff_t euler = 0;
  std::size_t components = 0, inconsistent = 0;
  bool operator==(const Topology&) const = default;
};
Topology TopologyOf(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) ++edges[std::minmax(t[c], t[(c + 1) % 3])];
  }
  Topology topology;
  for (const auto& [edge, count] : edges) topology.open[count] += count != 2;
  const MeshReport report = InspectMesh(mesh);
  topology.euler = std::ssize(mesh.vertices) - std::ssize(edges) + std::ssize(mesh.triangles);
  topology.components = report.components;
  topology.inconsistent = report.inconsistent_edges;
  return topology;
}

TEST(CurvedMesh, BringsASphereWithinTheTolerance) {
  const Vec3 ball = Vec3::Constant(0.03);
  const TriangleMesh coarse = MakeSphere(0.03, 1280);
  EXPECT_GT(ErrorsOf(coarse, ball).max, 120e-6);
  for (const double tolerance : {20e-6, 5e-6, 2e-6}) {
    const CurvedMesh fine = Refine(coarse, tolerance);
    // A parabola deviates from an arc of half angle 0.067 by 0.067^4/24 of the radius, 0.03 um, and
    // the middle of a patch by several times that.
    for (const Vec3& v : fine.mesh.vertices) EXPECT_NEAR(v.norm(), 0.03, 0.3e-6);
    EXPECT_LT(ErrorsOf(fine.mesh, ball).max, tolerance + 0.3e-6);
    EXPECT_EQ(fine.tolerance, tolerance);
  }
}

TEST(CurvedMesh, BringsAnEllipsoidNearerAsTheToleranceFalls) {
  const TriangleMesh coarse = MakeEllipsoid(kAxes, 5120);
  Errors last = ErrorsOf(coarse, kAxes);
  EXPECT_GT(last.max, 40e-6);
  for (const double tolerance : {20e-6, 10e-6, 5e-6, 3e-6, 1.5e-6}) {
    const Errors now = ErrorsOf(Refine(coarse, tolerance).mesh, kAxes);
    EXPECT_LT(now.max, tolerance + 1.2e-6) << "normals of 5,120 triangles are not exact";
    EXPECT_LE(now.max, last.max);
    EXPECT_LE(now.rms, last.rms);
    EXPECT_LE(now.slope, last.slope);
    last = now;
  }
  EXPECT_LT(last.slope, 0.4 * ErrorsOf(coarse, kAxes).slope);
}

TEST(CurvedMesh, IsNeverWorseHoweverCoarse) {
  for (const std::size_t triangles : {20u, 80u, 320u, 1280u}) {
    for (const Vec3& axes : {kAxes, Vec3(0.03, 0.03, 0.03), Vec3(0.05, 0.03, 0.02)}) {
      const TriangleMesh coarse = MakeEllipsoid(axes, triangles);
      EXPECT_LE(ErrorsOf(Refine(coarse, 1e-5).mesh, axes).rms, ErrorsOf(coarse, axes).rms)
          << triangles;
    }
  }
}

TEST(CurvedMesh, LeavesFlatBodiesAsTheyWere) {
  EXPECT_TRUE(
      Same(Refine(MakeBox(Vec3(0.05, 0.03, 0.02)), 1e-9).mesh, MakeBox(Vec3(0.05, 0.03, 0.02))));
  // A hexagonal prism's sides meet at 60 degrees, which are creases.
  const TriangleMesh prism = MakeRod({Vec3::Zero(), Vec3(0, 0, 0.05)}, {0.01, 0.01}, 6);
  EXPECT_TRUE(Same(Refine(prism, 1e-7).mesh, prism));
  // A round body that is already finer than the tolerance is left alone, too.
  const TriangleMesh sphere = MakeSphere(0.03, 5120);
  EXPECT_TRUE(Same(Refine(sphere, 1e-3).mesh, sphere));
}

TEST(CurvedMesh, RoundsACylinderAndKeepsItsRimSharpAndItsLidsFlat) {
  const double radius = 0.01, length = 0.04;
  const TriangleMesh coarse = MakeRod({Vec3::Zero(), Vec3(0, 0, length)}, {radius, radius}, 24);
  const CurvedMesh fine = Refine(coarse, 2e-6);
  EXPECT_GT(fine.mesh.triangles.size(), 2 * coarse.triangles.size());
  EXPECT_LT(fine.mesh.triangles.size(), 40 * coarse.triangles.size()) << "straight along the axis";
  EXPECT_TRUE(InspectMesh(fine.mesh).solid());
  for (const auto& t : fine.mesh.triangles) {
    const Vec3 &a = fine.mesh.vertices[t[0]], &b = fine.mesh.vertices[t[1]],
               &c = fine.mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a).normalized();
    const Vec3 middle = (a + b + c) / 3.0;
    const double r = middle.head<2>().norm();
    if (std::abs(n.z()) > 0.5) {
      EXPECT_NEAR(std::abs(n.z()), 1.0, 1e-9) << "a lid is flat";
      EXPECT_NEAR(std::abs(middle.z() - 0.5 * length), 0.5 * length, 1e-15);
    } else {
      // The parabolas of a diagonal and of the rim differ by 0.003 of 85 um, over some 2 mm.
      EXPECT_NEAR(n.z(), 0.0, 2e-4) << "the side is upright";
      EXPECT_NEAR(r, radius, 2e-6 + 1.5e-6);
    }
  }
  double furthest = 0.0, least = radius;
  for (const Vec3& v : fine.mesh.vertices) {
    const bool lid = std::abs(std::abs(v.z() - 0.5 * length) - 0.5 * length) < 1e-15;
    furthest = std::max(furthest, v.head<2>().norm());
    if (!lid) least = std::min(least, v.head<2>().norm());
    EXPECT_GE(v.z(), 0.0);
    EXPECT_LE(v.z(), length);
  }
  // Facets lie 85 um inside.  Normals from three long triangles at a vertex are not exact.
  EXPECT_NEAR(furthest, radius, 0.5e-6);
  EXPECT_NEAR(least, radius, 1.5e-6);
}

TEST(CurvedMesh, KeepsTheBoundaryOfAnOpenMesh) {
  TriangleMesh open = MakeSphere(0.03, 1280);
  std::erase_if(open.triangles, [&](const auto& t) {
    return std::max({open.vertices[t[0]].z(), open.vertices[t[1]].z(), open.vertices[t[2]].z()}) >
           0.01;
  });
  const MeshReport before = InspectMesh(open);
  ASSERT_GT(before.boundary_edges, 0u);
  const CurvedMesh fine = Refine(open, 5e-6);
  EXPECT_GT(fine.mesh.triangles.size(), 4 * open.triangles.size());
  const MeshReport after = InspectMesh(fine.mesh);
  EXPECT_EQ(after.boundary_edges, before.boundary_edges);
  EXPECT_EQ(TopologyOf(fine.mesh), TopologyOf(open));
  // Boundary edges stay straight, so points on them keep their depth; none lies higher.
  for (const Vec3& v : fine.mesh.vertices) EXPECT_LT(v.norm(), 0.03 + 0.5e-6);
  const Vec3 ball = Vec3::Constant(0.03);
  EXPECT_LT(ErrorsOf(fine.mesh, ball).rms, 0.3 * ErrorsOf(open, ball).rms);
  EXPECT_LE(ErrorsOf(fine.mesh, ball).max, ErrorsOf(open, ball).max + 0.5e-6);
}

/// A sphere with a fin: two edges have three triangles.
TEST(CurvedMesh, TakesMeshesThatAreNoManifold) {
  TriangleMesh mesh = MakeSphere(0.03, 320);
  const std::size_t first = mesh.triangles.size();
  const auto [i, j, k] = mesh.triangles[17];
  const Vec3 tip = 1.6 * mesh.vertices[i];
  mesh.vertices.push_back(tip);
  const auto at = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  mesh.triangles.push_back({i, j, at});  // edge i j has three triangles
  mesh.triangles.push_back({i, k, at});
  const CurvedMesh fine = Refine(mesh, 10e-6);
  EXPECT_EQ(TopologyOf(fine.mesh), TopologyOf(mesh));
  EXPECT_EQ(InspectMesh(fine.mesh).non_manifold_edges, 2u);
  EXPECT_EQ(std::count(fine.source.begin(), fine.source.end(), first), 1) << "a fin is flat";
  EXPECT_GT(fine.mesh.triangles.size(), 4 * mesh.triangles.size());
}

TEST(CurvedMesh, TakesDegenerateTrianglesAndThoseThatWindAgainstEachOther) {
  TriangleMesh mesh = MakeSphere(0.03, 320);
  auto& t = mesh.triangles;
  std::swap(t[40][0], t[40][1]);
  t.push_back({t[3][0], t[3][0], t[3][1]});
  t.push_back({t[5][0], t[5][1], t[5][1]});
  mesh.vertices.push_back(0.5 * (mesh.vertices[t[9][0]] + mesh.vertices[t[9][1]]));
  t.push_back({t[9][0], t[9][1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const CurvedMesh fine = Refine(mesh, 10e-6);
  for (const Vec3& v : fine.mesh.vertices) {
    ASSERT_TRUE(v.allFinite());
    EXPECT_LT(v.norm(), 0.0301);
  }
  EXPECT_EQ(InspectMesh(fine.mesh).degenerate_triangles, InspectMesh(mesh).degenerate_triangles);
  EXPECT_EQ(TopologyOf(fine.mesh).open, TopologyOf(mesh).open);
  // Only their neighbours stay flat.
  const std::size_t clean = Refine(MakeSphere(0.03, 320), 10e-6).mesh.triangles.size();
  EXPECT_GT(fine.mesh.triangles.size(), 9 * clean / 10);
  EXPECT_LT(fine.mesh.triangles.size(), clean);
}

TEST(CurvedMesh, HasNoCracksAndKeepsEveryTrianglesOrigin) {
  const std::vector<TriangleMesh> meshes{
      MakeEllipsoid(kAxes, 320), MakeBentPipe(0.02, 0.002, 0.1, 1.5),
      MeshOfField(ConeField(Vec3::Zero(), 0.01, Vec3(0.03, 0.0, 0.01), 0.002),
                  {Vec3::Constant(-0.03), Vec3::Constant(0.05)}, 0.004)};
  for (const TriangleMesh& mesh : meshes) {
    for (const double tolerance : {30e-6, 3e-6}) {
      const CurvedMesh fine = Refine(mesh, tolerance);
      EXPECT_GT(fine.mesh.triangles.size(), mesh.triangles.size());
      EXPECT_EQ(TopologyOf(fine.mesh), TopologyOf(mesh));
      EXPECT_EQ(InspectMesh(fine.mesh).degenerate_triangles, 0u);
      EXPECT_EQ(InspectMesh(fine.mesh).unused_vertices, 0u);
      ASSERT_EQ(fine.source.size(), fine.mesh.triangles.size());
      EXPECT_TRUE(std::is_sorted(fine.source.begin(), fine.source.end()));
      EXPECT_EQ(fine.source.back() + 1, mesh.triangles.size());
      EXPECT_TRUE(
          std::equal(mesh.vertices.begin(), mesh.vertices.end(), fine.mesh.vertices.begin()))
          << "what was there stays";
      for (std::size_t t = 0; t < fine.source.size(); ++t) {
        const auto normal = [](const TriangleMesh& m, std::size_t at) {
          const auto& [a, b, c] = m.triangles[at];
          return (m.vertices[b] - m.vertices[a]).cross(m.vertices[c] - m.vertices[a]).normalized();
        };
        EXPECT_GT(normal(fine.mesh, t).dot(normal(mesh, fine.source[t])), 0.5);
      }
    }
  }
}

TEST(CurvedMesh, WeldsWhatStandsAtOnePlace) {
  // As in STL: each triangle has its own vertices.
  const TriangleMesh sphere = MakeSphere(0.03, 320);
  test::Random random(1);
  const TriangleMesh loose = test::Unwelded(sphere, 0.0, random);
  const CurvedMesh a = Refine(sphere, 10e-6), b = Refine(loose, 10e-6);
  ASSERT_EQ(a.mesh.triangles.size(), b.mesh.triangles.size());
  for (std::size_t t = 0; t < a.mesh.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& v = a.mesh.vertices[a.mesh.triangles[t][c]];
      EXPECT_LT((v - b.mesh.vertices[b.mesh.triangles[t][c]]).norm(), 1e-15);
    }
  }
}

TEST(CurvedMesh, MakesANoisySphereNoNoisier) {
  const double radius = 0.03;
  for (const double noise : {5e-6, 20e-6, 60e-6}) {
    TriangleMesh mesh = MakeSphere(radius, 5120);
    test::Numbers numbers;
    for (Vec3& v : mesh.vertices) v *= 1.0 + numbers.Uniform(-noise, noise) / radius;
    const Errors before = ErrorsOf(mesh, Vec3::Constant(radius));
    const Errors after = ErrorsOf(Refine(mesh, 5e-6).mesh, Vec3::Constant(radius));
    EXPECT_LE(after.rms, before.rms) << noise;
    EXPECT_LE(after.slope, before.slope) << noise;
    EXPECT_LE(after.max, before.max) << noise;
  }
}

/// Noise on a plane has no underlying curved surface to find.
TEST(CurvedMesh, FollowsLittleOfTheNoiseOnAPlane) {
  constexpr std::uint32_t kSteps = 40;
  const double noise = 20e-6;
  TriangleMesh mesh;
  test::Numbers numbers;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    for (std::uint32_t k = 0; k <= kSteps; ++k) {
      mesh.vertices.emplace_back(2e-3 * i, 2e-3 * k, numbers.Uniform(-noise, noise));
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    for (std::uint32_t k = 0; k < kSteps; ++k) {
      const std::uint32_t a = i * (kSteps + 1) + k;
      mesh.triangles.push_back({a, a + kSteps + 1, a + kSteps + 2});
      mesh.triangles.push_back({a, a + kSteps + 2, a + 1});
    }
  }
  const auto slope = [](const TriangleMesh& m) {
    double sum = 0.0, area = 0.0;
    for (const auto& [i, j, k] : m.triangles) {
      const Vec3 n = (m.vertices[j] - m.vertices[i]).cross(m.vertices[k] - m.vertices[i]);
      sum += n.head<2>().squaredNorm() / n.norm();
      area += n.norm();
    }
    return std::sqrt(sum / area);
  };
  const TriangleMesh fine = Refine(mesh, 3e-6).mesh;
  double highest = 0.0;
  for (const Vec3& v : fine.vertices) highest = std::max(highest, std::abs(v.z()));
  EXPECT_LT(highest, 1.2 * noise);
  EXPECT_LT(slope(fine), 1.01 * slope(mesh));
  EXPECT_LT(fine.triangles.size(), 2 * mesh.triangles.size());
}

std::size_t Meetings(const TriangleMesh& mesh) {
  const auto corners = [&](const auto& t) {
    return test::Triangle{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  };
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& t : mesh.triangles) {
    boxes.emplace_back(mesh.vertices[t[0]]);
    boxes.back().extend(mesh.vertices[t[1]]).extend(mesh.vertices[t[2]]);
  }
  std::size_t meetings = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = i + 1; k < mesh.triangles.size(); ++k) {
      if (!boxes[i].intersects(boxes[k])) continue;
      const auto &s = mesh.triangles[i], &t = mesh.triangles[k];
      const bool neighbours = std::any_of(s.begin(), s.end(), [&](std::uint32_t v) {
        return std::find(t.begin(), t.end(), v) != t.end();
      });
      meetings += !neighbours && test::Meet(corners(s), corners(t));
    }
  }
  return meetings;
}

TEST(CurvedMesh, StaysFlatWhereItWouldComeIntoSomethingElse) {
  // A fin 0.2 mm above the middle of a facet whose patch rises by 2 mm.
  const TriangleMesh sphere = MakeSphere(0.03, 80);
  TriangleMesh mesh = sphere;
  const auto [i, j, k] = mesh.triangles[30];
  const Vec3 middle = (mesh.vertices[i] + mesh.vertices[j] + mesh.vertices[k]) / 3.0;
  const Vec3 out = middle.normalized();
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(middle + 0.2e-3 * out);
  mesh.vertices.push_back(middle + 5e-3 * out);
  mesh.vertices.push_back(middle + 5e-3 * out + 0.1 * (mesh.vertices[i] - middle));
  mesh.triangles.push_back({first, first + 1, first + 2});
  ASSERT_EQ(Meetings(mesh), 0u);
  const CurvedMesh fine = Refine(mesh, 300e-6);
  EXPECT_EQ(Meetings(fine.mesh), 0u);
  EXPECT_EQ(TopologyOf(fine.mesh), TopologyOf(mesh));
  EXPECT_EQ(std::count(fine.source.begin(), fine.source.end(), 30), 1);
  EXPECT_GT(fine.mesh.triangles.size(), 3 * sphere.triangles.size()) << "the rest is curved";
}

/// A square plate with a hole, and a wall below the hole's rim.  The rim's arcs would take more of
/// the plate than there is beside the hole's facets.
TEST(CurvedMesh, DoesNotFold) {
  constexpr double kHalf = 0.0093, kRadius = 0.0095;
  TriangleMesh mesh;
  for (int c = 0; c < 4; ++c) {
    const double a = 0.5 * M_PI * (c + 0.5);
    mesh.vertices.emplace_back(std::sqrt(2.0) * kHalf * std::cos(a),
                               std::sqrt(2.0) * kHalf * std::sin(a), 0.0);
  }
  for (const double z : {0.0, -0.01}) {
    for (int i = 0; i < 12; ++i) {
      const double a = M_PI / 6.0 * (i - 0.5);
      mesh.vertices.emplace_back(kRadius * std::cos(a), kRadius * std::sin(a), z);
    }
  }
  for (std::uint32_t q = 0; q < 4; ++q) {
    const std::uint32_t before = (q + 3) % 4, v = 4 + 3 * q;  // v: first vertex of a side's facet
    mesh.triangles.push_back({before, q, v + 1});
    mesh.triangles.push_back({before, v + 1, v});
    mesh.triangles.push_back({q, v + 2, v + 1});
    mesh.triangles.push_back({q, q == 3 ? 4u : v + 3, v + 2});
  }
  for (std::uint32_t i = 0; i < 12; ++i) {
    const std::uint32_t a = 4 + i, b = 4 + (i + 1) % 12;
    mesh.triangles.push_back({a, b, b + 12});
    mesh.triangles.push_back({a, b + 12, a + 12});
  }
  ASSERT_EQ(InspectMesh(mesh).inconsistent_edges, 0u);
  ASSERT_EQ(InspectMesh(mesh).boundary_edges, 16u);
  ASSERT_EQ(Meetings(mesh), 0u);
  const CurvedMesh fine = Refine(mesh, 10e-6);
  EXPECT_GT(fine.mesh.triangles.size(), 3 * mesh.triangles.size());
  EXPECT_EQ(Meetings(fine.mesh), 0u);
  for (const Vec3& v : fine.mesh.vertices)
    EXPECT_LE(v.head<2>().cwiseAbs().maxCoeff(), kHalf + 1e-9);
}

/// Two uneven sheets that meet in a sharp notch, like the folds of a scanned robe.
TriangleMesh Notch(test::Numbers& numbers) {
  constexpr std::uint32_t kRow = 12, kRows = 5;
  const auto shift = [&] { return numbers.Uniform(-0.8e-3, 0.8e-3); };
  TriangleMesh mesh;
  for (std::uint32_t k = 0; k < kRow; ++k) {
    const double x = shift();
    mesh.vertices.emplace_back(x, 2e-3 * k, shift());
  }
  for (const double side : {1.0, -1.0}) {
    const auto begin = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 1; i < kRows; ++i) {
      for (std::uint32_t k = 0; k < kRow; ++k) {
        const double x = shift(), y = shift(), height = 2e-3 * i * numbers.Uniform(0.02, 0.2);
        mesh.vertices.emplace_back(2e-3 * i + x, 2e-3 * k + y, side * height);
      }
    }
    const auto at = [&](std::uint32_t i, std::uint32_t k) {
      return i == 0 ? k : begin + (i - 1) * kRow + k;
    };
    for (std::uint32_t i = 0; i + 1 < kRows; ++i) {
      for (std::uint32_t k = 0; k + 1 < kRow; ++k) {
        std::array<std::uint32_t, 3> a{at(i, k), at(i, k + 1), at(i + 1, k + 1)};
        std::array<std::uint32_t, 3> b{at(i, k), at(i + 1, k + 1), at(i + 1, k)};
        if (side < 0.0) {
          std::swap(a[1], a[2]);
          std::swap(b[1], b[2]);
        }
        mesh.triangles.push_back(a);
        mesh.triangles.push_back(b);
      }
    }
  }
  return mesh;
}

TEST(CurvedMesh, KeepsTheFacesOfANotchApart) {
  test::Numbers numbers;
  int free = 0;
  for (int i = 0; i < 80; ++i) {
    const TriangleMesh mesh = Notch(numbers);
    ASSERT_EQ(InspectMesh(mesh).inconsistent_edges, 0u);
    if (Meetings(mesh) > 0) continue;
    ++free;
    const CurvedMesh fine = Refine(mesh, 4e-6);
    EXPECT_GT(fine.mesh.triangles.size(), 2 * mesh.triangles.size());
    EXPECT_EQ(Meetings(fine.mesh), 0u) << i;
  }
  EXPECT_GT(free, 20);
}

TEST(CurvedMesh, GivesTheSameBitsAgain) {
  const TriangleMesh mesh = MakeEllipsoid(kAxes, 1280);
  const CurvedMesh a = Refine(mesh, 3e-6), b = Refine(mesh, 3e-6);
  EXPECT_TRUE(Same(a.mesh, b.mesh));
  EXPECT_EQ(a.source, b.source);
}

TEST(CurvedMesh, SaysWhichToleranceItsTrianglesSufficeFor) {
  const TriangleMesh mesh = MakeEllipsoid(kAxes, 1280);
  const CurvedMesh capped = RefineCurved(mesh, {2.5e-6, 25'000});
  EXPECT_LE(capped.mesh.triangles.size(), 25'000u);
  EXPECT_EQ(capped.tolerance, 10e-6);
  EXPECT_TRUE(Same(capped.mesh, Refine(mesh, 10e-6).mesh));
  EXPECT_GT(Refine(mesh, 4e-6).mesh.triangles.size(), 25'000u);
  EXPECT_TRUE(Same(RefineCurved(mesh, {1e-6, 10}).mesh, mesh)) << "never less than there were";
}

}  // namespace
}  // namespace palpate
