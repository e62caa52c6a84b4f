#include "server/physics/surface/separating_plane.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

HullTree TreeOf(const std::vector<Vec3>& corners) {
  TriangleMesh mesh;
  mesh.vertices = corners;
  for (std::uint32_t i = 0; i + 2 < corners.size(); ++i)
    mesh.triangles.push_back({i, i + 1, i + 2});
  return HullTree(ContactMesh(mesh));
}

/// Differences between the tool's corners, at both ends of a motion, and the object's.
std::vector<Vec3> Differences(const std::vector<Vec3>& tool, const std::vector<Vec3>& object,
                              const ShapeMotion& motion) {
  std::vector<Vec3> all;
  for (const Placement* at : {&motion.from, &motion.to}) {
    for (const Vec3& a : tool) {
      for (const Vec3& b : object) all.push_back(*at * a - b);
    }
  }
  return all;
}

double LeastAlong(const std::vector<Vec3>& points, const Vec3& n) {
  double least = kInfinity;
  for (const Vec3& x : points) least = std::min(least, n.dot(x));
  return least;
}

/// The largest separation by any plane, found by trying every candidate for the best: one normal
/// for each vertex, edge and face of the differences' hull.  Not positive if none separates them.
double MostSeparation(const std::vector<Vec3>& points) {
  double most = -kInfinity;
  const auto consider = [&](const Vec3& direction) {
    const double length = direction.norm();
    if (!(length > 1e-12)) return;
    most = std::max(most, LeastAlong(points, direction / length));
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    consider(points[i]);
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 edge = points[j] - points[i];
      if (edge.squaredNorm() > 0.0) {
        consider(points[i] - points[i].dot(edge) / edge.squaredNorm() * edge);
      }
      for (std::size_t k = 0; k < j; ++k) {
        const Vec3 normal = edge.cross(points[k] - points[i]);
        consider(normal);
        consider(-normal);
      }
    }
  }
  return most;
}

struct Case {
  std::vector<Vec3> tool, object;
  double radius = 0.0;
  RelativePose from{Vec3::Zero(), Quat::Identity()}, to{Vec3::Zero(), Quat::Identity()};
};

/// Patches of three to five corners, from flat to round, near or inside each other.
Case MakeCase(Random& random, int candidate) {
  Case c;
  const auto corners = [&](int count, double flat) {
    std::vector<Vec3> all;
    for (int i = 0; i < count; ++i) {
      const Vec3 x = random.InCube(0.01);
      all.push_back({x.x(), x.y(), flat * x.z()});
    }
    return all;
  };
  const double flat[3] = {1.0, 0.01, 0.0};
  c.tool = corners(3 + candidate % 3, flat[candidate / 3 % 3]);
  c.object = corners(3 + candidate / 9 % 3, flat[candidate / 27 % 3]);
  if (candidate % 4 == 0) c.radius = 0.001;
  const Vec3 p = random.Direction() * random.Uniform(0.0, 0.03);
  const Quat q = random.Rotation();
  c.from = {p, q};
  c.to = candidate % 2 == 0 ? c.from : c.from.Moved(random.InCube(0.001), random.InCube(0.05));
  return c;
}

TEST(SeparatingPlane, IsFoundWhereThereIsOneAndOnlyThere) {
  Random random(81);
  int apart = 0, not_apart = 0;
  for (int candidate = 0; candidate < 600; ++candidate) {
    const Case c = MakeCase(random, candidate);
    const ShapeMotion motion{c.from, c.to};
    const HullTree tool = TreeOf(c.tool), object = TreeOf(c.object);
    const PatchPair pair{tool.HullOf(tool.root()), object.HullOf(object.root()), c.radius};
    const std::vector<Vec3> differences = Differences(c.tool, c.object, motion);
    const double most = MostSeparation(differences) - c.radius;
    for (const double least : {1e-9, 0.5e-6, 1e-4, 2e-3}) {
      SCOPED_TRACE("candidate " + std::to_string(candidate) + ", least " + std::to_string(least));
      SeparatingPlane plane;
      const Vec3 guess = random.Direction();
      if (FindPlane(pair, motion, guess, least, ActiveKernels(), plane)) {
        ++apart;
        EXPECT_NEAR(plane.n.norm(), 1.0, 1e-12);
        EXPECT_GE(std::min(plane.before, plane.after), least);
        EXPECT_NEAR(std::min(plane.before, plane.after),
                    LeastAlong(differences, plane.n) - c.radius, 1e-15);
      } else {
        ++not_apart;
        EXPECT_LE(most, least * (1.0 + 1e-6) + 1e-12);
      }
    }
  }
  EXPECT_GT(apart, 400);
  EXPECT_GT(not_apart, 300);
}

TEST(SeparatingPlane, IsTheGuessWhereThatHolds) {
  const HullTree tool = TreeOf({Vec3(0, 0, 0.02), Vec3(0.01, 0, 0.02), Vec3(0, 0.01, 0.02)});
  const HullTree object = TreeOf({Vec3(0, 0, 0), Vec3(0.01, 0, 0), Vec3(0, 0.01, 0)});
  const RelativePose at(Vec3::Zero(), Quat::Identity());
  const Vec3 guess = Vec3(0.1, -0.1, 1.0).normalized();
  SeparatingPlane plane;
  ASSERT_TRUE(FindPlane({tool.HullOf(tool.root()), object.HullOf(object.root()), 0.0}, {at, at},
                        guess, 1e-6, ActiveKernels(), plane));
  EXPECT_EQ(plane.n, guess);
  EXPECT_EQ(plane.tries, 1);
}

// Whole surfaces, whose hulls have hundreds of corners: triangulated spheres, apart or overlapping.
TEST(SeparatingPlane, TellsRoundPatchesApart) {
  const TriangleMesh ball = MakeEllipsoid(Vec3::Constant(0.01), 80);
  const HullTree tree = TreeOf(ball.vertices);
  Random random(82);
  for (int candidate = 0; candidate < 200; ++candidate) {
    const Vec3 way = random.Direction();
    const auto at = [&](double distance) {
      return RelativePose(distance * way, random.Rotation());
    };
    SeparatingPlane plane;
    const PatchPair pair{tree.HullOf(tree.root()), tree.HullOf(tree.root()), 0.0};
    const RelativePose away = at(0.0201), in = at(0.017);
    EXPECT_TRUE(FindPlane(pair, {away, away}, random.Direction(), 1e-6, ActiveKernels(), plane));
    EXPECT_FALSE(FindPlane(pair, {in, in}, random.Direction(), 1e-6, ActiveKernels(), plane));
    EXPECT_FALSE(FindPlane(pair, {away, in}, random.Direction(), 1e-6, ActiveKernels(), plane));
    EXPECT_FALSE(FindPlane(pair, {in, away}, random.Direction(), 1e-6, ActiveKernels(), plane));
  }
}

// Searches begin in whatever lane is free, beside others that began before.
TEST(SeparatingPlane, IsTheSameBesideOtherSearches) {
  Random random(83);
  const RelativePose from(Vec3(0.0, 0.0, 0.004), random.Rotation());
  const RelativePose to = from.Moved(random.InCube(0.001), random.InCube(0.05));
  const ShapeMotion motion{from, to};
  const double least = 1e-6;
  struct Search {
    HullTree tool, object;
    Vec3 guess;
    SeparatingPlane alone;
    bool found_alone;
    PatchPair pair() const { return {tool.HullOf(tool.root()), object.HullOf(object.root()), 0.0}; }
  };
  std::vector<Search> all;
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    const Case c = MakeCase(random, 2 * i);
    Search search{TreeOf(c.tool), TreeOf(c.object), random.Direction(), {}, false};
    search.found_alone =
        FindPlane(search.pair(), motion, search.guess, least, ActiveKernels(), search.alone);
    found += search.found_alone ? 1 : 0;
    all.push_back(std::move(search));
  }
  EXPECT_GT(found, 30);
  EXPECT_LT(found, 270);
  PlaneSearches searches;
  searches.Reset(least);
  std::size_t of_lane[PlaneSearches::kAtOnce], begun = 0, ended = 0;
  while (ended < all.size()) {
    // As many as there is room for, or fewer.
    for (int more = 1 + random.Below(8); more > 0 && !searches.IsFull() && begun < all.size();
         --more, ++begun) {
      of_lane[searches.Begin(all[begun].pair(), motion, all[begun].guess)] = begun;
    }
    for (std::uint32_t lanes = searches.Try(ActiveKernels()); lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      const Search& search = all[of_lane[lane]];
      const SeparatingPlane& plane = searches.plane(lane);
      ++ended;
      ASSERT_EQ(searches.Found(lane), search.found_alone);
      ASSERT_EQ(plane.tries, search.alone.tries);
      ASSERT_EQ(plane.n, search.alone.n);
      if (!search.found_alone) continue;
      ASSERT_EQ(plane.before, search.alone.before);
      ASSERT_EQ(plane.after, search.alone.after);
    }
  }
}

// No direction to start from: both pieces are the same single point.
TEST(SeparatingPlane, IsNoneBetweenPointsAtOnePlace) {
  const HullTree point = TreeOf({Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  const RelativePose at(Vec3::Zero(), Quat::Identity());
  SeparatingPlane plane;
  EXPECT_FALSE(FindPlane({point.HullOf(point.root()), point.HullOf(point.root()), 0.0}, {at, at},
                         Vec3::UnitZ(), 1e-9, ActiveKernels(), plane));
}

}  // namespace
}  // namespace palpate
