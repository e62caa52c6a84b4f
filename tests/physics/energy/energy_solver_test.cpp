#include "server/physics/energy/energy_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/physics/cut/cut_rows.h"
#include "server/physics/limits.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr int kMostSamples = 400, kMostRigid = 64;

/// A bur beside rigid rows.
struct BurAndRows {
  CutRows bur{kMostSamples};
  AlignedColumns columns{7, kMostRigid};
  int rigid_rows = 0;
  bool feasible = true;  ///< whether some place is known to satisfy the rigid rows
  Vec6 t = Vec6::Zero();

  void AddRigid(const Vec6& a, double b) {
    for (std::size_t c = 0; c < 7; ++c) {
      columns[c][rigid_rows] = c < 6 ? a[static_cast<int>(c)] : b;
      if (rigid_rows % 16 > 0) continue;
      for (int k = rigid_rows + 1; k < rigid_rows + 16; ++k) columns[c][k] = c < 6 ? 0.0 : -1e300;
    }
    ++rigid_rows;
  }
  QpRows rigid() const {
    QpRows rows{{}, columns[6], rigid_rows};
    for (std::size_t c = 0; c < 6; ++c) rows.a[c] = columns[c];
    return rows;
  }
  QpResult Solve(EnergySolver& solver, const Kernels& kernels, const Vec6& start = Vec6::Zero()) {
    Energy* const energy = &bur;
    return solver.Solve(kernels, t.data(), rigid(), {&energy, 1}, start.data(), {});
  }
};

Vec6 RowAt(const double* const a[6], int i) {
  Vec6 row;
  for (int c = 0; c < 6; ++c) row[c] = a[c][i];
  return row;
}

/// What a result lacks, in long double and by the law alone: no row is a spring here.
struct Judgement {
  long double unbalanced = 0.0L;  ///< |x - t - sum of the forces| [m]
  long double violation = 0.0L;   ///< the most by which a rigid row is violated [m]
  long double gap = 0.0L;         ///< of the energy to that of the dual at the result's forces, a
                                  ///< lower bound of the least energy [m^2]

  Judgement(const BurAndRows& problem, const QpResult& result) {
    std::array<long double, 6> sum{};  // of the forces
    long double energy = 0.0L, dual = 0.0L, loads = 0.0L;
    const auto add = [&](const Vec6& a, double b, long double f) {
      long double overlap = b, at_target = b;
      for (int c = 0; c < 6; ++c) {
        overlap -= static_cast<long double>(a[c]) * result.x[c];
        at_target -= static_cast<long double>(a[c]) * problem.t[c];
        sum[static_cast<std::size_t>(c)] += f * a[c];
      }
      dual += f * at_target;
      return overlap;
    };
    const CutRows& bur = problem.bur;
    for (int i = 0; i < bur.count(); ++i) {
      const long double P = bur.yielding.threshold[i], w = bur.yielding.weight[i];
      const long double f =
          std::clamp<long double>(bur.yielding.push[i], 0.0L, w > 0.0L ? 1e300L : P);
      const long double s =
          std::max(0.0L, add(RowAt(bur.yielding.rows.a, i), bur.yielding.rows.b[i], f));
      energy += P * s + 0.5L * w * s * s;
      if (f > P) dual -= 0.5L * (f - P) * (f - P) / w;
    }
    const QpRows rigid = problem.rigid();
    for (int i = 0; i < rigid.count; ++i) {
      const auto active = std::find(result.row, result.row + result.active, i) - result.row;
      const double load = active < result.active ? result.multiplier[active] : 0.0;
      const long double s = add(RowAt(rigid.a, i), rigid.b[i], load);
      violation = std::max(violation, s - static_cast<long double>(result.slack));
      loads += load;
    }
    long double push = 0.0L, left = 0.0L;
    for (std::size_t c = 0; c < 6; ++c) {
      const long double way =
          static_cast<long double>(result.x[c]) - problem.t[static_cast<int>(c)];
      energy += 0.5L * way * way;
      push += sum[c] * sum[c];
      left += (way - sum[c]) * (way - sum[c]);
    }
    dual -= 0.5L * push;
    if (result.status == QpStatus::kRelaxed) {
      const long double slack = result.slack, compliance = kJamCompliance;
      energy += 0.5L * slack * slack / compliance;
      dual -= 0.5L * loads * loads * compliance;
    }
    unbalanced = std::sqrt(left);
    gap = energy - dual;
  }
};

Vec6 RandomRow(Random& random, const Vec3& towards, double turn) {
  Vec3 n = random.Direction();
  if (random.Below(10) > 0 && n.dot(towards) < 0.0) n = -n;
  Vec6 row;
  row << n, random.InCube(turn);
  return row;
}

/// Adds rigid rows: any, copies, nearly parallel ones, and if asked for, contradictions.
void AddRigidRows(Random& random, double size, bool contradict, BurAndRows& problem) {
  const int count = 1 + random.Below(24);
  const double regain = random.Below(3) == 0 ? 0.3e-6 : 0.0;
  const Vec6 place = size * Vec6(Vec6::NullaryExpr([&] { return random.Uniform(-0.1, 0.1); }));
  for (int i = 0; i < count; ++i) {
    Vec6 a = -RandomRow(random, problem.t.head<3>().normalized(), 0.5);
    if (i > 0 && random.Below(3) == 0) {
      a = RowAt(problem.rigid().a, random.Below(problem.rigid_rows));
      const double by = random.Below(2) == 0 ? 0.0 : std::pow(10.0, random.Uniform(-9.0, -2.0));
      for (int c = 0; c < 6; ++c) a[c] += by * random.Uniform(-1.0, 1.0);
    }
    // Where most rows end at one place, as the gaps of a bur at rest do.
    const double gap = random.Below(2) == 0 ? 0.0 : random.Uniform(0.0, size);
    problem.AddRigid(
        a, a.dot(place) + (random.Below(4) == 0 ? 0.0 : -gap) + (contradict ? regain : 0.0));
  }
  if (!contradict) return;
  const Vec6 a = RowAt(problem.rigid().a, 0);
  problem.AddRigid(-a, size * 1e-3 - problem.rigid().b[0]);
  problem.feasible = false;
}

BurAndRows RandomBurAndRows(Random& random, int samples, bool contradict) {
  BurAndRows problem;
  const Vec3 towards = random.Direction();
  const int count = 1 + random.Below(samples);
  const double share = std::pow(10.0, random.Uniform(-3.0, 1.0));
  const double viscous = random.Below(2) == 0 ? 0.0 : std::pow(10.0, random.Uniform(-4.0, 1.0));
  const double size = std::pow(10.0, random.Uniform(-6.0, -2.7));
  const bool touches = random.Below(2) == 0;
  problem.t << size * towards, size * random.InCube(0.5);
  for (int i = 0; i < count; ++i) {
    const Vec6 a = RandomRow(random, towards, 0.5);
    const double gap = touches || random.Below(2) == 0 ? 0.0 : random.Uniform(0.0, size);
    problem.bur.Add({-a[0], -a[1], -a[2], -a[3], -a[4], -a[5]}, -gap,
                    size * random.Uniform(0.1, 1.0) / (share * count),
                    viscous * random.Uniform(0.1, 1.0) / count, 1e-9);
  }
  AddRigidRows(random, size, contradict, problem);
  return problem;
}

/// A bur as one was recorded in a bar that it had been pushed through: its front half at the wall,
/// of one threshold; and its neck against facets from both sides, of which each asks to be left by
/// 0.3 um, so that they contradict each other.
BurAndRows JammedNeck(Random& random) {
  BurAndRows problem;
  const Vec3 axis = random.Direction(), tip = -1.2 * axis;
  problem.t << 3e-6 * random.Direction(), random.Uniform(1e-6, 1.4e-4) * random.Direction();
  for (int i = 0; i < 49; ++i) {
    Vec3 n = random.Direction();
    if (n.dot(axis) < 0.0) n = -n;
    Vec6 a;
    a << n, tip.cross(n);
    const double gap = random.Below(6) == 0 ? 0.0 : random.Uniform(0.0, 1.5e-4);
    problem.bur.Add({-a[0], -a[1], -a[2], -a[3], -a[4], -a[5]}, -gap, 8.0169e-6, 0.0, 1e-9);
  }
  const int facets = 2 + random.Below(4);
  for (int f = 0; f < facets; ++f) {
    Vec3 n = random.Direction();
    for (int corner = random.Below(8); corner >= 0; --corner) {
      if (corner % 3 == 0) n = -n;
      const Vec3 lever = tip + 0.005 * random.Below(2) * axis;
      Vec6 a;
      a << n, lever.cross(n) + random.InCube(0.003 * random.Below(2));
      const double rounding = 1e-18 * random.Uniform(-1.0, 1.0);
      const bool regains = f > 0 || random.Below(3) > 0;
      problem.AddRigid(a, rounding + (regains ? 3e-7 : 0.0));
    }
  }
  return problem;
}

/// Checks that a result is the minimum, and of which problem.
void ExpectMinimum(const BurAndRows& problem, const QpResult& result, const std::string& which) {
  const double size = problem.t.norm();
  const Judgement found(problem, result);
  EXPECT_NE(result.status, QpStatus::kIterationLimit) << which;
  if (!problem.feasible) {
    EXPECT_EQ(result.status, QpStatus::kRelaxed) << which;
  }
  // Where no rigid row holds the tool, a row below its threshold may be a spring (README.md).
  double forces = size, spring = 0.0;
  for (int i = 0; i < problem.bur.count(); ++i) {
    const double P = problem.bur.yielding.threshold[i];
    const double push = problem.bur.yielding.push[i];
    forces += push;
    // It yields by push / kRigid, which costs (P - push) push / kRigid.
    spring += std::max(0.0, P - push) * push / limits::energy::kRigid;
  }
  for (int i = 0; i < result.active; ++i) forces += result.multiplier[i];
  const double rounding = 1e-15 * limits::energy::kRigid * problem.bur.count() * size;
  EXPECT_LT(found.unbalanced, 1e-12 * forces + (result.active == 0 ? rounding : 0.0)) << which;
  EXPECT_LT(found.violation, 1e-11 * size + 1e-14) << which;
  EXPECT_LT(std::abs(found.gap), 1e-11L * size * forces + spring) << which;
}

void SolveAll(std::uint64_t seed, int problems,
              const std::function<BurAndRows(Random&)>& next_problem) {
  Random random(seed);
  EnergySolver solver(kMostRigid, kMostSamples);
  int most = 0;
  for (int n = 0; n < problems && !testing::Test::HasFailure(); ++n) {
    BurAndRows problem = next_problem(random);
    const QpResult result = problem.Solve(solver, ActiveKernels());
    ExpectMinimum(problem, result,
                  "problem " + std::to_string(n) + " of seed " + std::to_string(seed) + ", " +
                      std::to_string(result.iterations) + " iterations");
    most = std::max(most, result.iterations);
  }
  testing::Test::RecordProperty("most_iterations", most);
}

std::function<BurAndRows(Random&)> AnyRows(int samples, bool contradict) {
  return [=](Random& random) { return RandomBurAndRows(random, samples, contradict); };
}

TEST(EnergySolver, EndsAtTheMinimumForABurBesideAnyRigidRows) {
  SolveAll(1, 3000, AnyRows(8, false));
  SolveAll(2, 1500, AnyRows(400, false));
}

TEST(EnergySolver, EndsAtTheMinimumOfAJamForABurBetweenContradictoryRows) {
  SolveAll(3, 3000, AnyRows(8, true));
  SolveAll(4, 1000, AnyRows(400, true));
}

TEST(EnergySolver, EndsAtTheMinimumForABurWhoseNeckIsJammed) {
  SolveAll(5, 3000, JammedNeck);
}

TEST(EnergySolver, EndsAtTheMinimumForABurAlone) {
  const auto alone = [](int samples) {
    return [=](Random& random) {
      BurAndRows problem = RandomBurAndRows(random, samples, false);
      problem.rigid_rows = 0;
      return problem;
    };
  };
  SolveAll(11, 3000, alone(8));
  SolveAll(12, 1500, alone(400));
}

TEST(EnergySolver, EndsThereFromAnyStart) {
  Random random(7);
  EnergySolver solver(kMostRigid, kMostSamples);
  for (int n = 0; n < 500; ++n) {
    BurAndRows problem = RandomBurAndRows(random, 300, false);
    const Vec6 here = Vec6::Map(problem.Solve(solver, ActiveKernels()).x);
    const Vec6 start = 1e-3 * Vec6::NullaryExpr([&] { return random.Uniform(-1.0, 1.0); });
    const QpResult other = problem.Solve(solver, ActiveKernels(), start);
    EXPECT_NE(other.status, QpStatus::kIterationLimit) << n;
    EXPECT_LT((Vec6::Map(other.x) - here).norm(), 1e-11 + 1e-9 * here.norm()) << n;
  }
}

TEST(EnergySolver, MovesNothingBelowTheThresholdAndYieldsViscouslyAboveIt) {
  // One row along z: a threshold of 0.5 N at 1 N/mm, and c = 1: the bur moves by half of any
  // excess.
  EnergySolver solver(kMostRigid, kMostSamples);
  for (const double z : {0.1e-3, 0.4999e-3, 0.6e-3, 2e-3}) {
    BurAndRows problem;
    problem.bur.Add({0, 0, -1, 0, 0, 0}, 0.0, 0.5e-3, 1.0, 1e-9);
    problem.t << 0.2e-3, 0.0, z, 0.0, 0.0, 0.0;
    const QpResult step = problem.Solve(solver, ActiveKernels());
    EXPECT_NEAR(step.x[2], std::max(0.0, (z - 0.5e-3) / 2.0), 0.5e-3 / limits::energy::kRigid);
    EXPECT_NEAR(step.x[0], 0.2e-3, 1e-17);  // along the surface it is free
    EXPECT_NEAR(problem.bur.yielding.push[0], z - step.x[2], 1e-15);
  }
}

/// 1/2 (x - rest) . A (x - rest) with a full matrix: what inertia or condensed tissue would be.
struct DenseEnergy final : Energy {
  Mat6 A;
  Vec6 rest;

  Vec6 ForceAt(const Vec6& x) const { return A * (rest - x); }
  int Add(const Evaluation&, const double* x, EnergyAt& at) const noexcept override {
    const Vec6 away = Vec6::Map(x) - rest, pull = ForceAt(Vec6::Map(x));
    at.twice -= away.dot(pull);
    Vec6::Map(at.force) += pull;
    for (int r = 0, k = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c, ++k) at.hessian[k] += A(r, c);
    }
    return 1;
  }
};

Vec6 RandomVec6(Random& random) {
  return Vec6::NullaryExpr([&] { return random.Uniform(-1.0, 1.0); });
}

DenseEnergy RandomDense(Random& random) {
  DenseEnergy dense;
  const Mat6 B = Mat6::NullaryExpr([&] { return random.Uniform(-1.0, 1.0); });
  dense.A = std::pow(10.0, random.Uniform(-2.0, 3.0)) * B * B.transpose();
  dense.rest = RandomVec6(random);
  return dense;
}

TEST(EnergySolver, FindsTheMinimumOfADenseEnergyAndTheCoupling) {
  Random random(9);
  EnergySolver solver(16, 0);
  constexpr double zero[6] = {};
  for (int n = 0; n < 300; ++n) {
    DenseEnergy dense = RandomDense(random);
    const Vec6 t = RandomVec6(random);
    Energy* const energy = &dense;
    const QpResult result = solver.Solve(ActiveKernels(), t.data(), {}, {&energy, 1}, zero, {});
    const Mat6 stiffness = Mat6::Identity() + dense.A;
    const Vec6 expected = stiffness.ldlt().solve(t + dense.A * dense.rest);
    EXPECT_EQ(result.status, QpStatus::kSolved);
    EXPECT_LT((Vec6::Map(result.x) - expected).norm(), 1e-12) << n;
    EXPECT_LT((dense.force - (expected - t)).norm(), 1e-9) << n;
    EXPECT_EQ(dense.pushing, 1);
  }
}

/// Rows and a target for which `x` is the minimum beside a dense energy, since there the forces are
/// in balance: rows of a bur that rest, give way and are free, and rigid rows that hold and are
/// free.
struct DenseAndRows : BurAndRows {
  DenseEnergy dense;
  Vec6 x;

  DenseAndRows(Random& random, int holding) : dense(RandomDense(random)), x(RandomVec6(random)) {
    t = x - dense.ForceAt(x);
    const auto row = [&](double overlap, double force) {
      const Vec6 a = RandomVec6(random).normalized();
      t -= force * a;
      return std::pair(a, a.dot(x) + overlap);
    };
    const auto add = [&](double overlap, double force, double P, double viscous) {
      const auto [a, b] = row(overlap, force);
      bur.Add({a[0], a[1], a[2], a[3], a[4], a[5]}, b, P, viscous, 1e-9);
    };
    for (int i = 0; i < 20; ++i) {
      const double P = random.Uniform(0.01, 0.1), s = random.Uniform(0.01, 0.5), c = i % 2 * s;
      add(s, P + c * s, P, c);
      add(-s, 0.0, P, c);
      if (i < 3) add(0.0, random.Uniform(0.1, 0.9) * P, P, c);
      const auto [free, below] = row(-s, 0.0);
      AddRigid(free, below);
    }
    for (int i = 0; i < holding; ++i) {
      const auto [a, b] = row(0.0, random.Uniform(0.1, 1.0));
      AddRigid(a, b);
    }
  }
};

TEST(EnergySolver, FindsTheMinimumOfADenseEnergyBesideThresholdsAndRigidRows) {
  Random random(10);
  EnergySolver solver(kMostRigid, kMostSamples);
  constexpr double zero[6] = {};
  for (int n = 0; n < 400; ++n) {
    DenseAndRows problem(random, n % 4);
    Energy* const energies[] = {&problem.bur, &problem.dense};
    const QpResult result =
        solver.Solve(ActiveKernels(), problem.t.data(), problem.rigid(), energies, zero, {});
    const Vec6 found = Vec6::Map(result.x);
    EXPECT_EQ(result.status, QpStatus::kSolved);
    EXPECT_LT((found - problem.x).norm(), 1e-7) << n;
    EXPECT_EQ(result.active, n % 4) << n;
    EXPECT_LT((problem.dense.force - problem.dense.ForceAt(found)).norm(), 1e-9) << n;
    Vec6 left = found - problem.t - problem.dense.force - problem.bur.force;
    for (int k = 0; k < result.active; ++k) {
      left -= result.multiplier[k] * RowAt(problem.rigid().a, result.row[k]);
    }
    EXPECT_LT(left.norm(), 1e-6) << n;
  }
}

TEST(EnergySolver, GivesTheSameBitsWithEveryInstructionSet) {
  const Kernels* kernels[3];
  const int levels = AvailableKernels(kernels);
  Random random(7);
  EnergySolver solver(kMostRigid, kMostSamples);
  for (int n = 0; n < 200; ++n) {
    BurAndRows problem = RandomBurAndRows(random, 100, n % 2 == 0);
    const QpResult expected = problem.Solve(solver, *kernels[0]);
    for (int level = 1; level < levels; ++level) {
      const QpResult result = problem.Solve(solver, *kernels[level]);
      for (int c = 0; c < 6; ++c) EXPECT_EQ(result.x[c], expected.x[c]) << kernels[level]->name;
      EXPECT_EQ(result.iterations, expected.iterations);
    }
  }
}

}  // namespace
}  // namespace palpate
