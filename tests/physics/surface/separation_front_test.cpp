#include "server/physics/surface/separation_front.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/optimised.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;
using Index = SeparationFront::Index;

std::vector<std::uint32_t> TrianglesBelow(const HullTree& tree, HullTree::Node node) {
  if (HullTree::IsLeaf(node)) return {HullTree::TriangleOf(node)};
  std::vector<std::uint32_t> all = TrianglesBelow(tree, tree.inner(node).child[0]);
  const std::vector<std::uint32_t> rest = TrianglesBelow(tree, tree.inner(node).child[1]);
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

/// Storage for the planes of eight pairs.
struct Columns {
  alignas(64) double column[9][16];
  PlaneColumns planes() {
    return {{column[0], column[1], column[2], column[3], column[4], column[5]},
            column[6],
            column[7],
            column[8]};
  }
};

/// The slack of a pair at the current pose.
double Refreshed(SeparationFront& front, Index i) {
  Columns columns;
  front.Refresh(ActiveKernels(), &i, 1, 0, columns.planes());
  EXPECT_EQ(front.expiry()[i], front.path() + columns.column[6][0]);
  return columns.column[6][0];
}

/// Drives a front between a tool and bodies at random, and checks it by enumeration.
class FrontBench {
 public:
  /// `bodies` copies of the object side by side.
  FrontBench(const TriangleMesh& tool_mesh, const TriangleMesh& object_mesh, int bodies,
             double size, std::uint64_t seed)
      : random(seed),
        size_(size),
        tool(ContactMesh(tool_mesh)),
        pose(Vec3(0.0, 0.0, size), Quat::Identity()) {
    const auto shape = std::make_shared<const ContactShape>(ContactMesh(object_mesh));
    for (Index body = 0; body < bodies; ++body) {
      objects.push_back({shape, PlacementOf({Vec3(size * body, 0, 0)})});
      plane_[body] = {Vec3::UnitZ(), pose.p};
    }
    front.Restart(tool, objects, pose);
  }

  /// The gap between the triangles below a pair, at the current pose.
  double Gap(const SeparationFront::Pair& pair, const Vec3& n) const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::uint32_t t : TrianglesBelow(tool.tree, pair.a)) {
      for (int c = 0; c < 3; ++c)
        low = std::min(low, n.dot(pose.R * tool.mesh.Corner(t, c) + pose.p));
    }
    const ContactBody& object = Object(pair);
    for (const std::uint32_t t : TrianglesBelow(object.shape->tree, pair.b)) {
      for (int c = 0; c < 3; ++c) {
        high = std::max(high, n.dot(object.X_BS * object.shape->mesh.Corner(t, c)));
      }
    }
    return low - high;
  }
  std::vector<Index> Front() const {
    std::vector<Index> all, left(objects.size());
    std::iota(left.begin(), left.end(), 0);
    while (!left.empty()) {
      const Index i = left.back(), child = front.pair(i).child;
      left.pop_back();
      if (child < 0) {
        all.push_back(i);
        continue;
      }
      EXPECT_EQ(front.pair(child).parent, i);
      EXPECT_EQ(front.pair(child + 1).parent, i);
      left.push_back(child + 1);
      left.push_back(child);
    }
    return all;
  }
  void SetOne() {
    const Index i = Pick(Front());
    const Vec3 n = random.Direction();
    front.Set(i, n, Gap(front.pair(i), n));
    plane_[i] = {n, pose.p};
  }
  void SplitOne() {
    std::vector<Index> open = Front();
    std::erase_if(open, [&](Index i) {
      return HullTree::IsLeaf(front.pair(i).a) && HullTree::IsLeaf(front.pair(i).b);
    });
    if (open.empty()) return;
    const Index i = Pick(open);
    const Vec3 n = random.Direction();
    const Index child =
        front.Split(i, tool.tree, Object(front.pair(i)).shape->tree, n, Gap(front.pair(i), n));
    ASSERT_GE(child, 0);
    plane_[child] = plane_[child + 1] = {n, pose.p};
  }
  void MergeOne() {
    std::vector<Index> parents;
    for (const Index i : Front()) {
      const Index parent = front.pair(i).parent;
      if (parent >= 0 && front.IsMergeable(parent)) parents.push_back(parent);
    }
    if (parents.empty()) return;
    const Index i = Pick(parents);
    const Vec3 n = random.Direction();
    front.Merge(i, n, Gap(front.pair(i), n));
    plane_[i] = {n, pose.p};
  }
  void MoveALittle(double share) {
    const Vec3 v = share * size_ * random.Direction();
    pose = pose.Moved(v, share * random.Direction());
    front.Move(pose, tool.mesh.reach());
    // The tool's node moves no further than this.
    gone_ += v.norm() + share * tool.mesh.reach() + 1e-9 * size_;
  }

  /// The front is a cut: each pair of triangles is below exactly one pair; no other slot expires.
  void JudgeCover() const {
    const std::size_t tools = tool.mesh.triangles().size();
    const std::size_t of_object = objects[0].shape->mesh.triangles().size();
    std::vector<int> seen(tools * objects.size() * of_object, 0);
    std::vector<bool> of_front((front.slots() + 7) / 8 * 8, false);
    const std::vector<Index> all = Front();
    EXPECT_EQ(front.size(), all.size());
    for (const Index i : all) {
      of_front[static_cast<std::size_t>(i)] = true;
      const SeparationFront::Pair& pair = front.pair(i);
      const auto body = static_cast<std::size_t>(pair.body);
      for (const std::uint32_t t : TrianglesBelow(tool.tree, pair.a)) {
        for (const std::uint32_t o : TrianglesBelow(objects[body].shape->tree, pair.b)) {
          ++seen[(body * tools + t) * of_object + o];
        }
      }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<long>(seen.size()));
    for (std::size_t i = 0; i < of_front.size(); ++i) {
      EXPECT_EQ(std::isfinite(front.expiry()[i]), of_front[i]) << "slot " << i;
    }
  }
  /// No pair's slack exceeds its gap, neither by its plane nor by its expiry.
  void JudgeSlack() const {
    for (const Index i : Front()) {
      const Vec3& n = plane_.at(i).n;
      const double gap = Gap(front.pair(i), n);
      const double error = 1e-13 * (gone_ + size_);
      EXPECT_LE(front.expiry()[static_cast<std::size_t>(i)] - front.path(), gap + error);
      // In a copy, so that planes from older poses are checked as well.
      SeparationFront copy = front;
      if (copy.IsKept(i)) {
        EXPECT_LE(Refreshed(copy, i), gap + error) << "pair " << i;
        EXPECT_EQ(copy.Normal(i), n);
        EXPECT_LE(copy.expiry()[static_cast<std::size_t>(i)] - copy.path(), gap + error);
      }
    }
  }

  Random random;
  double size_;
  MovingBody tool;
  std::vector<ContactBody> objects;
  RelativePose pose;
  SeparationFront front;

 private:
  const ContactBody& Object(const SeparationFront::Pair& pair) const {
    return objects[static_cast<std::size_t>(pair.body)];
  }
  Index Pick(const std::vector<Index>& of) {
    return of[static_cast<std::size_t>(random.Below(static_cast<int>(of.size())))];
  }
  struct Plane {
    Vec3 n, p;
  };
  std::map<Index, Plane> plane_;  ///< each pair's plane, and the tool's position when it was set
  double gone_ = 0.0;
};

TEST(SeparationFront, StaysACutWithTrueSlacksWhateverHappens) {
  for (const double size : {1e-3, 0.1, 10.0}) {
    for (std::uint64_t seed = 1; seed <= (test::kOptimised ? 6 : 2); ++seed) {
      SCOPED_TRACE(testing::Message() << "size " << size << ", seed " << seed);
      FrontBench bench(MakeEllipsoid(size * Vec3(0.5, 0.3, 0.2), 20),
                       MakeBox(size * Vec3(1, 2, 0.1)), 1 + static_cast<int>(seed % 3), size, seed);
      for (int turn = 0; turn < 150; ++turn) {
        switch (bench.random.Below(4)) {
          case 0:
            bench.SplitOne();
            break;
          case 1:
            turn < 75 ? bench.SplitOne() : bench.MergeOne();
            break;
          case 2:
            bench.SetOne();
            break;
          default:
            bench.MoveALittle(bench.random.Below(2) == 0 ? 1e-4 : 0.05);
        }
        if (turn % 5 != 0) continue;
        bench.JudgeCover();
        bench.JudgeSlack();
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

TEST(SeparationFront, LosesNoMoreOfASlackThanTheNodeComesNearer) {
  // Moving along its plane costs no slack; moving nearer costs that distance; turning in place
  // costs at most the radius times the angle.
  const TriangleMesh tool = MakeBox(Vec3(0.02, 0.02, 0.02)), floor = MakeBox(Vec3(0.2, 0.2, 0.02));
  FrontBench bench(tool, floor, 1, 0.03, 1);
  const Vec3 n = Vec3::UnitZ();
  bench.front.Set(0, n, bench.Gap(bench.front.pair(0), n));
  double slack = Refreshed(bench.front, 0);
  EXPECT_NEAR(slack, 0.01, 1e-15);
  const auto go = [&](const Vec3& v, const Vec3& phi) {
    bench.pose = bench.pose.Moved(v, phi);
    bench.front.Move(bench.pose, bench.tool.mesh.reach());
    slack = Refreshed(bench.front, 0);
  };
  go(Vec3(0.05, -0.03, 0.0), Vec3::Zero());
  EXPECT_NEAR(slack, 0.01, 1e-12);
  go(Vec3(0.0, 0.0, -0.004), Vec3::Zero());
  EXPECT_NEAR(slack, 0.006, 1e-12);
  // About the plane's normal nothing comes nearer.
  go(Vec3::Zero(), Vec3(0.0, 0.0, 0.01));
  EXPECT_NEAR(slack, 0.006, 1e-12);
  go(Vec3::Zero(), Vec3(0.01, 0.0, 0.0));
  EXPECT_NEAR(slack, 0.006 - 0.01 * 0.01 * std::sqrt(3.0), 1e-7);
  // Back where it was, it has what it had.
  go(Vec3::Zero(), Vec3(-0.01, 0.0, 0.0));
  EXPECT_NEAR(slack, 0.006, 1e-12);
  EXPECT_NEAR(bench.front.path(), std::hypot(0.05, 0.03) + 0.004 + 0.03 * 0.01 * std::sqrt(3.0),
              1e-9);
}

TEST(SeparationFront, ForgetsWhereTheToolWasSixtyFourMovesAgo) {
  FrontBench bench(MakeBox(Vec3::Constant(0.02)), MakeBox(Vec3::Constant(0.02)), 1, 0.05, 2);
  bench.front.Set(0, Vec3::UnitZ(), 0.03);
  for (int i = 0; i < 63; ++i) {
    bench.MoveALittle(1e-4);
    ASSERT_TRUE(bench.front.IsKept(0)) << i;
    SeparationFront copy = bench.front;
    EXPECT_LE(Refreshed(copy, 0), bench.Gap(bench.front.pair(0), Vec3::UnitZ()) + 1e-12);
  }
  for (int i = 0; i < 200; ++i) {
    bench.MoveALittle(1e-4);
    ASSERT_FALSE(bench.front.IsKept(0)) << i;
  }
  bench.front.Set(0, Vec3::UnitZ(), 0.02);
  EXPECT_TRUE(bench.front.IsKept(0));
  EXPECT_EQ(Refreshed(bench.front, 0), 0.02);
}

TEST(SeparationFront, OpensTheLargerNodeOfAPair) {
  FrontBench bench(MakeBox(Vec3::Constant(0.02)), MakeBox(Vec3::Constant(0.2)), 1, 0.3, 3);
  const Index child =
      bench.front.Split(0, bench.tool.tree, bench.objects[0].shape->tree, Vec3::UnitZ(), 0.1);
  for (Index side = 0; side < 2; ++side) {
    EXPECT_EQ(bench.front.pair(child + side).a, bench.tool.tree.root());
    EXPECT_EQ(bench.front.pair(child + side).b, bench.objects[0].shape->tree.inner(0).child[side]);
  }
}

TEST(SeparationFront, OffersEveryPairThatCanBeClosedOnceARound) {
  FrontBench bench(MakeEllipsoid(Vec3(0.02, 0.03, 0.01), 80), MakeSphere(0.02, 80), 2, 0.1, 4);
  for (int i = 0; i < 200; ++i) bench.SplitOne();
  std::map<Index, int> offered;
  const auto round = [&] {
    offered.clear();
    for (int calls = 0; calls < 2000; ++calls) {
      const Index i = bench.front.NextMergeable();
      if (i < 0) continue;
      EXPECT_TRUE(bench.front.IsMergeable(i));
      ++offered[i];
    }
  };
  round();
  std::size_t mergeable = 0;
  for (const Index i : bench.Front()) {
    const Index parent = bench.front.pair(i).parent;
    if (parent < 0 || bench.front.pair(parent).child != i || !bench.front.IsMergeable(parent))
      continue;
    ++mergeable;
    EXPECT_GT(offered[parent], 0);
  }
  EXPECT_GT(mergeable, 10u);
  // Pairs to be retried later are not offered until the tool has moved that far.
  const Index later = offered.begin()->first;
  bench.front.RetryAfter(later, 0.01);
  round();
  EXPECT_EQ(offered.count(later), 0u);
  bench.pose = bench.pose.Moved(Vec3(0.0, 0.0, 0.011), Vec3::Zero());
  bench.front.Move(bench.pose, bench.tool.mesh.reach());
  round();
  EXPECT_EQ(offered.count(later), 1u);
}

TEST(SeparationFront, HasRoomForTheMostPairsAndSaysSoWhereThereIsNoMore) {
  const TriangleMesh tool = MakeSphere(0.02, 320), object = MakeSphere(0.03, 1280);
  const MovingBody a{ContactMesh(tool)};
  const ContactBody b{std::make_shared<const ContactShape>(ContactMesh(object)), PlacementOf({})};
  SeparationFront front;
  front.Reserve();
  const std::uint64_t before = test::AllocationsOfThisThread();
  RelativePose at(Vec3(0.0, 0.0, 0.1), Quat::Identity());
  front.Restart(a, {&b, 1}, at);
  Index next = 0, refused = -1;
  const auto is_pair_of_triangles = [&](Index i) {
    return HullTree::IsLeaf(front.pair(i).a) && HullTree::IsLeaf(front.pair(i).b);
  };
  for (; refused < 0; ++next) {
    if (next == 1 || is_pair_of_triangles(next)) continue;
    if (front.Split(next, a.tree, b.shape->tree, Vec3::UnitZ(), 0.01) < 0) refused = next;
  }
  EXPECT_EQ(front.slots(), SeparationFront::kMaxSlots);
  EXPECT_EQ(front.size(), SeparationFront::kMaxSlots / 2);
  EXPECT_LT(front.pair(refused).child, 0);
  EXPECT_TRUE(std::isfinite(front.expiry()[refused]));
  // Closing a pair makes room again, any number of times.
  for (int i = 0; i < 1000; ++i) {
    Index closed = -1;
    while (closed < 0 || closed == front.pair(refused).parent) closed = front.NextMergeable();
    front.Merge(closed, Vec3::UnitX(), 0.02);
    ASSERT_GE(front.Split(refused, a.tree, b.shape->tree, Vec3::UnitZ(), 0.01), 0);
    refused = closed;
    at = at.Moved(Vec3(1e-5, 0.0, 0.0), Vec3(0.0, 1e-4, 0.0));
    front.Move(at, a.mesh.reach());
  }
  front.Restart(a, {&b, 1}, at);
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

TEST(SeparationFront, GoesOnAlikeWhereItIsCopied) {
  FrontBench bench(MakeEllipsoid(Vec3(0.02, 0.03, 0.01), 80), MakeSphere(0.02, 80), 3, 0.1, 5);
  for (int i = 0; i < 300; ++i) {
    if (i % 3 == 0) bench.MoveALittle(1e-3);
    if (i % 3 == 1) bench.SplitOne();
    if (i % 7 == 2) bench.MergeOne();
  }
  SeparationFront copy = bench.front;
  const Random random = bench.random;
  const RelativePose pose = bench.pose;
  const auto go_on = [&] {
    for (int i = 0; i < 300; ++i) {
      if (i % 3 == 0) bench.MoveALittle(1e-3);
      if (i % 3 == 1) bench.SplitOne();
      if (i % 4 == 2) bench.MergeOne();
      if (i % 5 == 0) bench.front.NextMergeable();
    }
  };
  go_on();
  std::swap(copy, bench.front);
  bench.random = random;
  bench.pose = pose;
  go_on();
  ASSERT_EQ(copy.slots(), bench.front.slots());
  EXPECT_EQ(copy.path(), bench.front.path());
  EXPECT_EQ(std::memcmp(copy.expiry(), bench.front.expiry(), sizeof(double) * copy.slots()), 0);
  for (std::size_t i = 0; i < copy.slots(); ++i) {
    const auto &a = copy.pair(static_cast<Index>(i)), &b = bench.front.pair(static_cast<Index>(i));
    ASSERT_EQ(a.a, b.a);
    ASSERT_EQ(a.b, b.b);
    ASSERT_EQ(a.child, b.child);
    const auto index = static_cast<Index>(i);
    ASSERT_EQ(copy.plane(index).slack, bench.front.plane(index).slack);
  }
  EXPECT_EQ(copy.NextMergeable(), bench.front.NextMergeable());
}

}  // namespace
}  // namespace palpate
