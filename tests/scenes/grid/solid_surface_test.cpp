#include "scenes/grid/solid_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/mesh/mesh_query.h"
#include "tests/scenes/grid/cut_block.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::CutBlock;
using test::Random;

constexpr double kBallRadius = 0.25e-3;
const Vec3 kSize = CutBlock::Size();

const Quat kAlong = Quat::Identity();
const Quat kQuarter = RotationExp(Vec3(0, M_PI / 4.0, 0));
const Quat kAskew =
    RotationExp(Vec3(0, 35.0 / 180.0 * M_PI, 0)) * RotationExp(Vec3(0, 0, M_PI / 6.0));

void Riddle(CutBlock& block, std::uint64_t seed, int count, double least, double most) {
  Random random(seed);
  for (int n = 0; n < count; ++n) {
    const Bur ball = Bur::Ball(random.Uniform(least, most));
    const Vec3 p = random.InCube(1e-3) - Vec3(0, 0, 0.4e-3);
    block.cut.Remove(ball, {block.q * p, random.Rotation()},
                     random.Uniform(0.0, 0.1e-3) * random.Direction());
  }
}

TriangleMesh MeshOf(const SolidSurface& surface) {
  return {surface.vertices, surface.triangles};
}

double VolumeOf(const SolidSurface& surface) {
  double volume = 0.0;
  for (const auto& [i, j, k] : surface.triangles) {
    volume += surface.vertices[i].dot(surface.vertices[j].cross(surface.vertices[k])) / 6.0;
  }
  return volume;
}

/// Each edge has two triangles, one in each direction, and no triangle repeats a vertex.
void ExpectClosed(const SolidSurface& surface) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> ways;
  for (const auto& t : surface.triangles) {
    for (std::size_t n = 0; n < 3; ++n) {
      ASSERT_NE(t[n], t[(n + 1) % 3]);
      ASSERT_TRUE(ways.insert({t[n], t[(n + 1) % 3]}).second);
    }
  }
  for (const auto& [a, b] : ways) ASSERT_TRUE(ways.count({b, a}));
  EXPECT_EQ(surface.materials.size(), surface.triangles.size());
}

double BoxDistance(const Vec3& p_P) {
  const Vec3 q = (p_P + Vec3(0, 0, 0.4e-3)).cwiseAbs() - 0.5 * kSize;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

struct Errors {
  double sum = 0.0, most = 0.0;
  int count = 0;
  void Add(double error) {
    sum += error * error;
    most = std::max(most, std::abs(error));
    ++count;
  }
  double rms() const { return std::sqrt(sum / count); }
};

TEST(SolidSurface, IsClosedAndTurnedOutwardsHoweverItIsRiddled) {
  for (const Quat& q : {kAlong, kAskew}) {
    // Holes from below a cell's size to several cells, which makes cells of every kind.
    for (const auto& [least, most, count] :
         {std::tuple{0.04e-3, 0.09e-3, 2000}, {0.08e-3, 0.16e-3, 400}, {0.1e-3, 0.4e-3, 40}}) {
      CutBlock block(100e-6, q);
      Riddle(block, 11, count, least, most);
      const SolidSurface surface = WholeSurface(block.cut);
      EXPECT_GT(surface.triangles.size(), 1000u);
      ExpectClosed(surface);
      EXPECT_GT(VolumeOf(surface), 0.0);
    }
  }
}

// One vertex for eight cells beside cells of all kinds; lattice points on a face up to rounding.
TEST(SolidSurface, IsClosedWhereFlatAndRiddledPartsMeet) {
  for (const std::uint64_t seed : {1, 2, 5, 34, 37, 62, 82, 98, 102, 106}) {
    Random random(seed);
    const double h = seed % 3 == 0 ? 100e-6 : seed % 3 == 1 ? 50e-6 : 70e-6;
    const Quat q = seed % 4 == 0   ? Quat::Identity()
                   : seed % 4 == 1 ? RotationExp(Vec3(0, 0, 1e-7))
                   : seed % 4 == 2 ? random.Rotation()
                                   : RotationExp(random.Uniform(0.0, 0.1) * random.Direction());
    CutBlock block(h, q);
    const int count = seed % 5 == 0 ? 0 : static_cast<int>(random.Uniform(1.0, 200.0));
    const double most = seed % 2 == 0 ? 0.12e-3 : 0.5e-3;
    for (int n = 0; n < count; ++n) {
      const Bur bur = n % 3 != 0 ? Bur::Ball(random.Uniform(0.03e-3, most))
                                 : Bur::Cylinder(random.Uniform(0.05e-3, most),
                                                 random.Uniform(0.2e-3, 0.9e-3), 0.02e-3);
      const Vec3 p = random.InCube(1e-3) - Vec3(0, 0, 0.4e-3);
      block.cut.Remove(bur, {block.q * p, random.Rotation()},
                       random.Uniform(0.0, 0.3e-3) * random.Direction());
    }
    SCOPED_TRACE(seed);
    ExpectClosed(WholeSurface(block.cut));
  }
}

// Most of it has one vertex for eight cells, so a quarter of the triangles, equally accurate.
TEST(SolidSurface, OfAWideBallHasFewTrianglesAndIsNear) {
  constexpr double h = 50e-6, radius = 2e-3;
  const TriangleMesh ball = MakeSphere(radius, 80000);
  const SolidGrid solid(ball, {.spacing = h, .most_bytes = 64u << 20}, "ball");
  const SolidSurface surface = WholeSurface(CutField(solid, 64u << 20, "ball"));
  ExpectClosed(surface);
  EXPECT_NEAR(VolumeOf(surface), 4.0 / 3.0 * M_PI * std::pow(radius, 3), 1e-3 * VolumeOf(surface));
  // About 1.5 lattice edges cross the surface per h^2, with two triangles each.
  EXPECT_LT(surface.triangles.size(), 0.4 * 3.0 * 4.0 * M_PI * radius * radius / (h * h));
  Errors errors;
  for (const auto& [i, j, k] : surface.triangles) {
    for (const Vec3& w : {Vec3(1, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.4, 0.3, 0.3)}) {
      const Vec3 p =
          w[0] * surface.vertices[i] + w[1] * surface.vertices[j] + w[2] * surface.vertices[k];
      errors.Add(p.norm() - radius);
    }
  }
  EXPECT_LT(errors.rms(), 0.02 * h);
  EXPECT_LT(errors.most, 0.05 * h);
}

TEST(SolidSurface, EnclosesWhatTheGridSaysIsLeft) {
  for (const Quat& q : {kAlong, kQuarter, kAskew}) {
    CutBlock block(50e-6, q);
    const double before = VolumeOf(WholeSurface(block.cut));
    EXPECT_NEAR(before, kSize.prod(), 1e-3 * kSize.prod());
    const double removed =
        block.Move(Bur::Ball(kBallRadius), Vec3(-0.4e-3, 0.1e-3, 0), Vec3(0.4e-3, 0, -0.1e-3))
            .total() +
        block
            .Move(Bur::Cylinder(0.2e-3, 0.6e-3, 0.05e-3), Vec3(0, -0.5e-3, -0.3e-3),
                  Vec3(0, 0.5e-3, -0.3e-3))
            .total();
    const double after = VolumeOf(WholeSurface(block.cut));
    EXPECT_NEAR((before - after) / removed, 1.0, 4e-3);
  }
}

TEST(SolidSurface, OfAGrooveLiesAtTheExactSweep) {
  for (const double depth : {-0.1e-3, 0.0, 0.1e-3}) {
    for (const Quat& q : {kAlong, kQuarter, kAskew}) {
      CutBlock block(50e-6, q);
      const Vec3 a(-0.4e-3, 0, -depth), b(0.4e-3, 0, -depth);
      block.Go(Bur::Ball(kBallRadius), a, b);
      const SolidSurface surface = WholeSurface(block.cut);
      const auto sweep = [&](const Vec3& p) {
        return (p - Vec3(std::clamp(p.x(), a.x(), b.x()), 0, -depth)).norm() - kBallRadius;
      };
      Errors from, to;
      // Points on the triangles near the groove.
      for (const auto& [i, j, k] : surface.triangles) {
        for (const Vec3& w : {Vec3(1, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.4, 0.3, 0.3)}) {
          const Vec3 p = q.conjugate() * (w[0] * surface.vertices[i] + w[1] * surface.vertices[j] +
                                          w[2] * surface.vertices[k]);
          const double of_box = BoxDistance(p), of_cut = -sweep(p);
          if (of_cut < -0.1e-3) continue;
          from.Add(of_box > 0.0 && of_cut > 0.0 ? std::hypot(of_box, of_cut)
                                                : std::max(of_box, of_cut));
        }
      }
      // Points on the swept surface: along the groove, from rim to rim inclusive.
      const TriangleMesh mesh = MeshOf(surface);
      const MeshQuery query(mesh);
      const double rim = std::asin(depth / kBallRadius);
      for (int n = 0; n <= 200; ++n) {
        for (int m = 0; m <= 40; ++m) {
          const double angle = -rim + (M_PI + 2.0 * rim) * m / 40.0;
          const Vec3 p(a.x() + (b.x() - a.x()) * n / 200.0, kBallRadius * std::cos(angle),
                       -depth - kBallRadius * std::sin(angle));
          to.Add(query.Nearest(q * p).distance);
        }
      }
      EXPECT_LE(from.rms(), 2e-6);
      EXPECT_LE(to.rms(), 2e-6);
      EXPECT_LE(from.most, 12.5e-6);
      EXPECT_LE(to.most, 12.5e-6);
    }
  }
}

TEST(SolidSurface, KeepsTheEdgesOfABoxSharp) {
  Random random(12);
  std::vector<Quat> turns{kAlong, kQuarter, kAskew};
  while (turns.size() < 12) turns.push_back(random.Rotation());
  for (const double h : {100e-6, 50e-6}) {
    for (const Quat& q : turns) {
      const CutBlock block(h, q);
      const TriangleMesh mesh = MeshOf(WholeSurface(block.cut));
      const MeshQuery query(mesh);
      Errors edges, corners, vertices;
      for (int axis = 0; axis < 3; ++axis) {
        for (int n = 0; n < 4; ++n) {
          Vec3 at = 0.5 * kSize;
          if (n & 1) at[(axis + 1) % 3] *= -1.0;
          if (n & 2) at[(axis + 2) % 3] *= -1.0;
          for (int m = 0; m <= 400; ++m) {
            at[axis] = kSize[axis] * (m / 400.0 - 0.5);
            const bool corner = std::abs(at[axis]) > 0.5 * kSize[axis] - 1.5 * h;
            const double away = query.Nearest(q * (at - Vec3(0, 0, 0.4e-3))).distance;
            (corner ? corners : edges).Add(away);
          }
        }
      }
      for (const Vec3& v : mesh.vertices) vertices.Add(BoxDistance(q.conjugate() * v));
      EXPECT_LE(edges.most, 0.25 * h);
      EXPECT_LE(edges.rms(), 0.05 * h);
      // A corner has three faces that no single cell's crossings determine.
      EXPECT_LE(corners.most, 0.7 * h);
      EXPECT_LE(vertices.most, 0.4 * h);
      EXPECT_LE(vertices.rms(), 0.01 * h);
      // Triangles facing the wrong way, folded over an edge.
      double folded = 0.0;
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [i, j, k] = mesh.triangles[t];
        const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
        const Vec3 middle = (a + b + c) / 3.0, out = 1e-6 * query.FaceNormal(t);
        if (BoxDistance(q.conjugate() * (middle + out)) <
            BoxDistance(q.conjugate() * (middle - out))) {
          folded += 0.5 * (b - a).cross(c - a).norm();
        }
      }
      EXPECT_LE(folded, h * h);
    }
  }
}

TEST(SolidSurface, VerticesOfTwoBlocksAreTheSameBits) {
  CutBlock block(100e-6, kAskew);
  Riddle(block, 13, 200, 0.05e-3, 0.3e-3);
  std::map<std::uint64_t, Vec3> known;
  std::size_t again = 0, triangles = 0;
  SolidSurface one;
  for (std::size_t b = 0; b < block.cut.field().lattice().block_count(); ++b) {
    TakeSurface(block.solid, block.cut.field(), b, one);
    triangles += one.triangles.size();
    for (std::size_t n = 0; n < one.vertices.size(); ++n) {
      const auto [place, fresh] = known.try_emplace(one.numbers[n], one.vertices[n]);
      again += !fresh;
      ASSERT_EQ(place->second, one.vertices[n]);
    }
  }
  const SolidSurface all = WholeSurface(block.cut);
  EXPECT_GT(again, 500u);
  EXPECT_EQ(all.vertices.size(), known.size());
  EXPECT_EQ(all.triangles.size(), triangles);
}

TEST(SolidSurface, KnowsWhatLiesBehindIt) {
  const auto layers = [](const Vec3& p) { return std::uint8_t(p.z() > -0.1e-3 ? 1 : 3); };
  CutBlock block(50e-6, kAlong, layers);
  block.Go(Bur::Ball(kBallRadius), Vec3(0, 0, kBallRadius), Vec3(0, 0, -0.1e-3));
  const SolidSurface surface = WholeSurface(block.cut);
  std::size_t of[2] = {};
  for (std::size_t n = 0; n < surface.triangles.size(); ++n) {
    const auto& [i, j, k] = surface.triangles[n];
    const double z =
        (surface.vertices[i].z() + surface.vertices[j].z() + surface.vertices[k].z()) / 3.0;
    if (std::abs(z + 0.1e-3) < 75e-6) continue;
    EXPECT_EQ(surface.materials[n], z > -0.1e-3 ? 1 : 3);
    ++of[z > -0.1e-3];
  }
  EXPECT_GT(of[0], 1000u);
  EXPECT_GT(of[1], 1000u);
}

// A block's rim is what shares a vertex with it in the whole surface, and hardly more: both
// triangles of a quad or none.
TEST(SolidSurface, ABlocksRimIsItsNeighboursTriangles) {
  CutBlock block(100e-6, kAskew);
  Riddle(block, 7, 12, 0.15e-3, 0.4e-3);
  using Numbers = std::array<std::uint64_t, 3>;
  const auto numbers_of = [](const SolidSurface& surface, std::size_t triangle) {
    Numbers numbers;
    for (std::size_t c = 0; c < 3; ++c) {
      numbers[c] = surface.numbers[surface.triangles[triangle][c]];
    }
    return numbers;
  };
  const SolidSurface whole = WholeSurface(block.cut);
  std::map<std::uint64_t, std::vector<std::size_t>> at;
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    for (const std::uint64_t number : numbers_of(whole, t)) at[number].push_back(t);
  }
  SolidSurface own, both;
  for (std::size_t b = 0; b < block.solid.field().lattice().block_count(); ++b) {
    TakeSurface(block.solid, block.cut.field(), b, own);
    const std::size_t count = TakeSurfaceAndRim({block.solid, block.cut.field()}, b, both);
    ASSERT_EQ(count, own.triangles.size());
    std::set<Numbers> expected, found;
    for (std::size_t t = 0; t < count; ++t) {
      ASSERT_EQ(numbers_of(both, t), numbers_of(own, t));
      for (const std::uint64_t number : numbers_of(own, t)) {
        for (const std::size_t beside : at[number]) expected.insert(numbers_of(whole, beside));
      }
    }
    for (std::size_t t = 0; t < both.triangles.size(); ++t) found.insert(numbers_of(both, t));
    ASSERT_TRUE(std::ranges::includes(found, expected)) << b;
    EXPECT_LT(found.size(), expected.size() + expected.size() / 4 + 8) << b;
  }
}

}  // namespace
}  // namespace palpate
