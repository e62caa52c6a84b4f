#include "scenes/grid/cut_field.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/scenes/grid/cut_block.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/random.h"
#include "tests/support/volume_left.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::CutBlock;
using test::Random;
using testing::HasSubstr;

constexpr double kRadius = 0.25e-3;

/// Removed by a ball whose centre plunges to `depth` >= 0.
double PlungeVolume(double depth) {
  return M_PI * kRadius * kRadius * depth + 2.0 / 3.0 * M_PI * std::pow(kRadius, 3);
}

/// Removed by a ball whose centre moves `length` along the plane, at a depth from -R to R.
double GrooveVolume(double depth, double length) {
  const double r = kRadius, height = r + depth;
  const double section =
      0.5 * M_PI * r * r + depth * std::sqrt(r * r - depth * depth) + r * r * std::asin(depth / r);
  return section * length + M_PI * height * height * (3.0 * r - height) / 3.0;
}

const Quat kTurned = RotationExp(Vec3(0, 0, M_PI / 6));
const Quat kTilted = RotationExp(Vec3(0.35, 0.6, 0.2));

struct Spacing {
  double h, bound;
};

// At a spacing of 50 um a groove 50 um deep is one voxel deep and consists of rims alone.
TEST(CutField, TakesTheVolumeOfAPlungeAndOfAGroove) {
  const Bur ball = Bur::Ball(kRadius);
  for (const auto& [h, bound] : {Spacing{100e-6, 0.021}, Spacing{50e-6, 0.0012}}) {
    for (const Quat& q : {Quat::Identity(), kTurned, kTilted}) {
      CutBlock down(h, q);
      const Vec3 at(0.03e-3, 0.02e-3, 0.0);
      const double plunge =
          down.Move(ball, at + Vec3(0, 0, 0.3e-3), at + Vec3(0, 0, -0.2e-3)).total();
      EXPECT_NEAR(plunge / PlungeVolume(0.2e-3), 1.0, 0.5 * bound);
      for (const double depth : {-0.2e-3, -0.1e-3, 0.0, 0.1e-3}) {
        CutBlock along(h, q);
        const Vec3 from(-0.4e-3, 0.01e-3, -depth), to(0.4e-3, 0.01e-3, -depth);
        const double groove = along.Move(ball, from, to).total();
        EXPECT_NEAR(groove / GrooveVolume(depth, 0.8e-3), 1.0,
                    depth < -0.15e-3 ? bound : 0.7 * bound)
            << depth;
      }
    }
  }
}

TEST(CutField, TakesTheVolumeOfASlotThatAFissureBurMills) {
  const double r = 0.3e-3, depth = 0.35e-3, length = 0.5e-3;
  const Bur bur = Bur::Cylinder(r, 1.5e-3, 0.0);
  for (const Quat& q : {Quat::Identity(), kTurned, kTilted}) {
    CutBlock block(50e-6, q);
    const Vec3 above(-0.25e-3, 0, 0.02e-3), down(-0.25e-3, 0, -depth);
    double volume = block.Move(bur, above, down, 10e-6).total();
    EXPECT_NEAR(volume / (M_PI * r * r * depth), 1.0, 0.005);
    volume += block.Move(bur, down, down + Vec3(length, 0, 0), 10e-6).total();
    EXPECT_NEAR(volume / ((M_PI * r * r + 2.0 * r * length) * depth), 1.0, 0.005);
  }
}

TEST(CutField, ATrephineTakesARingAndLeavesTheCore) {
  const double inner = 0.5e-3, outer = 0.8e-3, depth = 0.3e-3;
  const Bur bur({{inner, 0}, {outer, 0}, {outer, 2e-3}, {inner, 2e-3}, {inner, 0}}, 0.0);
  for (const Quat& q : {Quat::Identity(), kTurned, kTilted}) {
    CutBlock block(50e-6, q);
    const double volume = block.Move(bur, Vec3(0, 0, 0.02e-3), Vec3(0, 0, -depth), 10e-6).total();
    EXPECT_NEAR(volume / (M_PI * (outer * outer - inner * inner) * depth), 1.0, 0.01);
  }
}

// The steps of a straight path form a convex region: interpolation stays inside it.
TEST(CutField, HoldsTheDistanceToTheWayAtItsPointsAndLessBetweenThem) {
  CutBlock block(50e-6, kTilted);
  const Vec3 from(-0.3e-3, 0.1e-3, 0.1e-3), to(0.4e-3, -0.1e-3, -0.15e-3);
  block.Go(Bur::Ball(kRadius), from, to, 20e-6);
  const auto depth = [&](const Vec3& p_B) {
    const Vec3 p = block.q.conjugate() * p_B, way = to - from;
    const double t = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
    return kRadius - (p - from - t * way).norm();
  };
  const SparseField& field = block.cut.field();
  const double band = field.band();
  const Lattice& lattice = field.lattice();
  for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
    for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
      for (int i = 0; i < 8 * lattice.blocks[0]; ++i) {
        if (block.solid.field().entry(field.BlockIndex(i >> 3, j >> 3, k >> 3)) < -1) continue;
        const double truth = std::clamp(depth(lattice.Point(i, j, k)), -band, band);
        ASSERT_NEAR(field.At(i, j, k), truth, 2e-9);
      }
    }
  }
  Random random(11);
  for (int n = 0; n < 20000; ++n) {
    const Vec3 p_B = block.q * (random.InCube(0.4e-3) - Vec3(0, 0, 0.4e-3));
    const double truth = depth(p_B);
    if (std::abs(truth) > 0.5 * band) continue;
    const double distance = field.Sample(p_B).distance;
    ASSERT_LE(distance, truth + 2e-9);
    // A chord's sagitta across the path, h^2/8R, in each of three directions.
    ASSERT_GE(distance, truth - 3.0 * 50e-6 * 50e-6 / (8.0 * (kRadius - std::abs(truth))));
  }
}

TEST(CutField, RimBetweenCutAndOldSurfaceStaysSharp) {
  CutBlock block(50e-6, Quat::Identity());
  block.Go(Bur::Ball(kRadius), Vec3(0, 0, 0.3e-3), Vec3(0, 0, -0.1e-3));
  // 5 um below the old surface, and as far outside the hole.
  for (const double angle : {0.0, 0.3, 0.8, 2.0, 4.0}) {
    const double r = kRadius + 5e-6;
    const Vec3 p(r * std::cos(angle), r * std::sin(angle), -5e-6);
    EXPECT_NEAR(block.cut.Sample(p).distance, -5e-6, 1e-7);
  }
}

struct Move {
  Bur bur;
  Pose X_BT;
  Vec3 step;
};

std::vector<Move> RandomMoves(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Move> moves;
  for (int n = 0; n < count; ++n) {
    const double r = random.Uniform(0.05e-3, 0.3e-3);
    const Bur bur = n % 3 == 0   ? Bur::Ball(r)
                    : n % 3 == 1 ? Bur::Cylinder(r, random.Uniform(3.0, 6.0) * r, 0.2 * r)
                                 : Bur::Cone(0.5 * r, r, 4.0 * r, 0.0);
    moves.push_back({bur,
                     {random.InCube(1e-3) - Vec3(0, 0, 0.4e-3), random.Rotation()},
                     random.Uniform(0.0, 0.15e-3) * random.Direction()});
  }
  return moves;
}

TEST(CutField, SolidOnlyShrinks) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    CutBlock block(100e-6, kTilted);
    const Lattice& lattice = block.cut.field().lattice();
    const auto size = 512 * lattice.block_count();
    std::vector<float> phi(size, -1.0f);
    const double whole = test::TotalLeft(block.cut);
    double left = whole;
    for (const Move& move : RandomMoves(seed, 40)) {
      block.cut.Remove(move.bur, move.X_BT, move.step);
      std::size_t n = 0;
      for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
        for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
          for (int i = 0; i < 8 * lattice.blocks[0]; ++i, ++n) {
            const float value = block.cut.field().At(i, j, k);
            EXPECT_GE(value, phi[n]);
            phi[n] = value;
          }
        }
      }
      const double now = test::TotalLeft(block.cut);
      EXPECT_LE(now, left + 2e-4 * whole);  // volumes at a crease are not exact
      left = now;
    }
  }
}

TEST(CutField, DoesNotDependOnTheOrderOfSteps) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    CutBlock one(100e-6, kTurned), other(100e-6, kTurned);
    std::vector<Move> moves = RandomMoves(seed, 60);
    const double whole = test::TotalLeft(one.cut);
    for (const Move& m : moves) one.cut.Remove(m.bur, m.X_BT, m.step);
    std::reverse(moves.begin(), moves.end());
    for (const Move& m : moves) other.cut.Remove(m.bur, m.X_BT, m.step);
    const Lattice& lattice = one.cut.field().lattice();
    for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
      for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
        for (int i = 0; i < 8 * lattice.blocks[0]; ++i) {
          ASSERT_EQ(one.cut.field().At(i, j, k), other.cut.field().At(i, j, k));
        }
      }
    }
    const double left = test::TotalLeft(one.cut);
    EXPECT_LT(left, whole - 0.1e-9);
    EXPECT_EQ(test::TotalLeft(other.cut), left);
    // Once more: nothing is left to remove.
    for (const Move& m : moves) one.cut.Remove(m.bur, m.X_BT, m.step);
    EXPECT_EQ(test::TotalLeft(one.cut), left);
  }
}

// Points out of the bur's reach since its last step are skipped, but not after another bur.
TEST(CutField, OfAWalkIsTheSameWhetherOrNotAnotherBurCutsInBetween) {
  const Bur bur = Bur::Cylinder(0.25e-3, 1e-3, 0.05e-3), other = Bur::Ball(0.05e-3);
  for (const std::uint64_t seed : {8, 9, 10}) {
    CutBlock alone(50e-6, kTilted), between(50e-6, kTilted);
    Random random(seed);
    Pose X_BT{kTilted * Vec3(0, 0, -0.2e-3), kTilted};
    const Pose X_BO{kTilted * Vec3(0.7e-3, 0.6e-3, -0.6e-3), Quat::Identity()};
    Vec3 way = 3e-6 * random.Direction();
    alone.cut.Remove(other, X_BO, Vec3::Zero());
    const double whole = test::TotalLeft(alone.cut);
    for (int n = 0; n < 300; ++n) {
      if (n % 40 == 0) way = random.Uniform(0.0, 10e-6) * random.Direction();
      // It continues from where it was, apart from an occasional turn or jump.
      if (n % 7 == 0) X_BT.q = (RotationExp(3e-3 * random.Direction()) * X_BT.q).normalized();
      if (n % 50 == 49) X_BT.p += 20e-6 * random.Direction();
      alone.cut.Remove(bur, X_BT, way);
      between.cut.Remove(bur, X_BT, way);
      between.cut.Remove(other, X_BO, Vec3::Zero());
      X_BT.p += way;
    }
    EXPECT_LT(test::TotalLeft(alone.cut), whole - 0.01e-9);
    const Lattice& lattice = alone.cut.field().lattice();
    for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
      for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
        for (int i = 0; i < 8 * lattice.blocks[0]; ++i) {
          ASSERT_EQ(alone.cut.field().At(i, j, k), between.cut.field().At(i, j, k));
        }
      }
    }
  }
}

/// Copies the changed blocks, as a follower of the cut does.
void Follow(CutField& cut, SparseField& copy, std::size_t most) {
  for (std::size_t block = 0; most > 0 && cut.TakeChanged(block); --most) {
    const std::int32_t entry = cut.field().entry(block);
    if (entry < 0) {
      if (copy.entry(block) >= 0) copy.Release(block, entry);
      continue;
    }
    const std::int32_t to = copy.entry(block) >= 0 ? copy.entry(block) : copy.Acquire(block);
    std::copy_n(cut.field().values(entry), SparseField::kPoints, copy.values(to));
  }
}

void ExpectSamePoints(const SparseField& one, const SparseField& other) {
  const auto& blocks = one.lattice().blocks;
  for (int k = 0; k < 8 * blocks[2]; ++k) {
    for (int j = 0; j < 8 * blocks[1]; ++j) {
      for (int i = 0; i < 8 * blocks[0]; ++i) ASSERT_EQ(one.At(i, j, k), other.At(i, j, k));
    }
  }
}

TEST(CutField, WhoTakesTheBlocksThatChangedAFewAtATimeHasAllInTheEnd) {
  CutBlock block(50e-6, kTilted);
  SparseField copy(block.cut.field().lattice(), block.cut.field().band(), SparseField::kBelow);
  copy.Reserve(block.solid.solid_blocks());
  Random random(5);
  Vec3 at(0, 0, 0.4e-3);
  for (int n = 0; n < 40; ++n) {
    const Vec3 to = random.InCube(0.7e-3) - Vec3(0, 0, 0.3e-3);
    block.Go(Bur::Ball(0.2e-3), at, to, 60e-6);
    at = to;
    Follow(block.cut, copy, 5);
  }
  Follow(block.cut, copy, SIZE_MAX);
  ExpectSamePoints(block.cut.field(), copy);
  std::size_t left = 0;
  EXPECT_FALSE(block.cut.TakeChanged(left));
}

TEST(CutField, MadeWholeIsAsNew) {
  CutBlock used(50e-6, kTilted), fresh(50e-6, kTilted);
  const Bur bur = Bur::Cylinder(0.3e-3, 1e-3, 0.05e-3);
  used.Go(bur, Vec3(-1e-3, 0, -0.2e-3), Vec3(0, 0.3e-3, -0.9e-3), 30e-6);
  used.cut.MakeWhole();
  std::size_t changed = 0;
  EXPECT_FALSE(used.cut.TakeChanged(changed));
  ExpectSamePoints(used.cut.field(), fresh.cut.field());
  const Vec3 from(0, 0, 0.3e-3), to(0.2e-3, 0.1e-3, -0.4e-3);
  EXPECT_EQ(used.Move(bur, from, to).volume, fresh.Move(bur, from, to).volume);
  ExpectSamePoints(used.cut.field(), fresh.cut.field());
}

TEST(CutField, CountsEachMaterialForItself) {
  const auto layers = [](const Vec3& p) {
    return std::uint8_t((kTilted.conjugate() * p).z() > -0.1e-3 ? 1 : 3);
  };
  CutBlock block(50e-6, kTilted, layers);
  const auto before = block.cut.VolumeLeft();
  const CutBlock::Moved removal =
      block.Move(Bur::Ball(kRadius), Vec3(0, 0, 0.3e-3), Vec3(0, 0, -0.3e-3));
  const double upper = M_PI * kRadius * kRadius * 0.1e-3;
  EXPECT_NEAR(removal.volume[1] / upper, 1.0, 0.01);
  EXPECT_NEAR(removal.volume[3] / (PlungeVolume(0.3e-3) - upper), 1.0, 0.01);
  EXPECT_EQ(removal.volume[0], 0.0);
  EXPECT_EQ(removal.volume[2], 0.0);
  const Vec3 size = CutBlock::Size();
  EXPECT_NEAR((before[1] + before[3]) / size.prod(), 1.0, 0.001);
  EXPECT_NEAR(before[1] / (size.x() * size.y() * 0.1e-3), 1.0, 0.01);
}

TEST(CutField, StorageOfWhatIsClearIsUsedAgain) {
  CutBlock block(50e-6, Quat::Identity());
  const SparseField& field = block.cut.field();
  const std::size_t before = field.free_blocks();
  const Bur bur = Bur::Cylinder(0.7e-3, 3e-3, 0.0);
  block.Go(bur, Vec3(0, 0, 0.1e-3), Vec3(0, 0, -1.2e-3), 20e-6);
  // Right through the block, and wider than two blocks of the grid.
  std::size_t clear = 0, stored = 0;
  for (std::size_t n = 0; n < field.lattice().block_count(); ++n) {
    clear += field.entry(n) == SparseField::kAbove;
    stored += field.entry(n) >= 0;
  }
  EXPECT_GT(clear, 0u);
  EXPECT_EQ(field.free_blocks() + stored, before);
  EXPECT_EQ(block.cut.Sample(Vec3(0, 0, -0.4e-3)).distance, field.band());
}

TEST(CutField, TakesNothingWhereItIsFull) {
  CutBlock block(50e-6, Quat::Identity(), nullptr, 3);
  const CutBlock::Moved removal =
      block.Move(Bur::Ball(kRadius), Vec3(0, 0, -0.3e-3), Vec3(0, 0, -0.3e-3));
  EXPECT_TRUE(removal.full);
  EXPECT_EQ(removal.total(), 0.0);
  EXPECT_EQ(block.cut.field().free_blocks(), 3u);
  EXPECT_LT(block.cut.Sample(Vec3(0, 0, -0.3e-3)).distance, 0.0);
}

TEST(CutField, TakesNothingWhereTheBurIsNowhere) {
  CutBlock block(50e-6, Quat::Identity());
  const Bur ball = Bur::Ball(kRadius);
  for (const Vec3& p :
       {Vec3(1.0, 0, 0), Vec3(0, 0, std::nan("")), Vec3(-INFINITY, 0, 0), Vec3(0, 1e300, 0)}) {
    block.cut.Remove(ball, {p, Quat::Identity()}, Vec3::Zero());
  }
  block.cut.Remove(ball, Pose{}, Vec3(std::nan(""), 0, 0));
  const Quat no_turn(std::nan(""), 0, 0, 0);
  block.cut.Remove(ball, {Vec3::Zero(), no_turn}, Vec3::Zero());
  EXPECT_EQ(block.cut.changes(), 0u);
  EXPECT_EQ(block.cut.Sample(Vec3(0, 0, -0.2e-3)).distance, -block.solid.field().band());
}

TEST(CutField, ToothOfTenMillimetresAndAllThatCanBeCutOfItFitInto64Megabytes) {
  const SolidGrid solid(MakeEllipsoid(Vec3(4e-3, 3.5e-3, 5e-3), 5120), {.spacing = 50e-6}, "tooth");
  const std::size_t left = (64u << 20) - solid.bytes();
  const CutField cut(solid, left, "tooth");
  EXPECT_GE(cut.field().free_blocks(), solid.solid_blocks());
  EXPECT_LE(cut.bytes(), left);
  EXPECT_THAT(ComplaintOf([&] { CutField(solid, 1u << 20, "tooth"); }),
              HasSubstr("tooth: cutting at 50 um takes"));
}

/// Sends phi_c as fields send it to each other.
void Tell(CutField& from, CutField& to, std::size_t block) {
  const std::int32_t entry = from.field().entry(block);
  to.Merge(block, entry < 0 ? nullptr : from.field().values(entry));
}

// Three burs each cut a field of their own; changes reach the others at once or later, twice or
// reordered.  In the end all must equal a single field cut by all three.
TEST(CutField, HoldsTheSameBitsInWhateverOrderItMergesWhatOthersCut) {
  Random random(17);
  for (int round = 0; round < 3; ++round) {
    CutBlock all(100e-6, kTilted);
    const auto below = [&](std::size_t n) {
      return static_cast<std::size_t>(random.Below(static_cast<int>(n)));
    };
    std::deque<CutBlock> hands;  // a deque never moves them
    std::vector<Vec3> at;
    for (int n = 0; n < 3; ++n) {
      hands.emplace_back(100e-6, kTilted);
      at.emplace_back(random.InCube(0.4e-3));
    }
    const Bur bur = round == 0 ? Bur::Cylinder(0.2e-3, 0.8e-3, 0.05e-3) : Bur::Ball(kRadius);
    struct News {
      std::size_t from, to, block;
    };
    std::vector<News> waiting;
    const auto tell = [&](std::size_t n) {
      Tell(hands[waiting[n].from].cut, hands[waiting[n].to].cut, waiting[n].block);
      if (random.Below(4) == 0) return;  // it arrives again later
      waiting[n] = waiting.back();
      waiting.pop_back();
    };
    for (int step = 0; step < 300; ++step) {
      const std::size_t hand = below(3);
      const Vec3 to = random.InCube(0.4e-3) - Vec3(0, 0, 0.2e-3);
      const Vec3 next = at[hand] + 30e-6 * (to - at[hand]).normalized();
      for (CutBlock* block : {&hands[hand], &all}) block->Go(bur, at[hand], next);
      at[hand] = next;
      for (std::size_t block = 0; hands[hand].cut.TakeChanged(block);) {
        for (std::size_t other = 0; other < 3; ++other) {
          if (other != hand) waiting.push_back({hand, other, block});
        }
      }
      for (std::size_t n = below(20); n > 0 && !waiting.empty(); --n) {
        tell(below(waiting.size()));
      }
    }
    while (!waiting.empty()) tell(below(waiting.size()));
    const double left = all.cut.VolumeLeft()[0];
    for (CutBlock& hand : hands) {
      ExpectSamePoints(hand.cut.field(), all.cut.field());
      EXPECT_EQ(hand.cut.VolumeLeft()[0], left);
    }
  }
}

// A bur larger than a block of the grid leaves some blocks empty.
TEST(CutField, MergesWhatIsGoneAltogether) {
  CutBlock one(100e-6, kTilted), other(100e-6, kTilted);
  one.Go(Bur::Ball(1.2e-3), Vec3(-0.5e-3, 0, -0.2e-3), Vec3(0.5e-3, 0, -0.2e-3), 50e-6);
  std::vector<std::size_t> told;
  for (std::size_t block = 0; one.cut.TakeChanged(block);) told.push_back(block);
  int clear = 0;
  for (const std::size_t block : told) {
    const bool is_clear = one.cut.field().entry(block) == SparseField::kAbove;
    clear += is_clear;
    const std::uint32_t before = other.cut.changes();
    Tell(one.cut, other.cut, block);
    EXPECT_EQ(other.cut.changes(), before + 1);
    EXPECT_EQ(other.cut.ChangedAt(block), before + 1) << "for contact to follow";
    if (is_clear) {
      EXPECT_EQ(other.cut.field().entry(block), SparseField::kAbove);
    }
    Tell(one.cut, other.cut, block);
    EXPECT_EQ(other.cut.changes(), before + 1) << "it knew that";
  }
  EXPECT_GT(clear, 0);
  EXPECT_FALSE(other.cut.has_changed()) << "what came from others is not told";
  ExpectSamePoints(other.cut.field(), one.cut.field());
  EXPECT_EQ(other.cut.VolumeLeft()[0], one.cut.VolumeLeft()[0]);
}

TEST(CutField, MergesWithoutAskingForMemory) {
  CutBlock one(50e-6, kTilted), other(50e-6, kTilted);
  one.Go(Bur::Ball(kRadius), Vec3(-0.4e-3, 0, -0.1e-3), Vec3(0.4e-3, 0, -0.1e-3), 20e-6);
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (std::size_t block = 0; one.cut.TakeChanged(block);) Tell(one.cut, other.cut, block);
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
  ExpectSamePoints(other.cut.field(), one.cut.field());
}

}  // namespace
}  // namespace palpate
