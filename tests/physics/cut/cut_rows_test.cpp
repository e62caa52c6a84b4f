#include "server/physics/cut/cut_rows.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/energy/energy_solver.h"
#include "tests/support/cut_of_rows.h"
#include "tests/support/volume_left.h"

namespace palpate {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadius = 0.25e-3, kStiffness = 1000.0;
const Material kHard{.cutting_pressure = 2e6, .cutting_viscosity = 0.5e9};
const Material kSoft{.cutting_pressure = 0.5e6, .cutting_viscosity = 0.1e9};

/// A block whose body frame B is rotated and displaced in W; its face is the plane z = 0 of W.
struct Trial {
  explicit Trial(double spacing = 50e-6, int count = 256,
                 std::function<std::uint8_t(const Vec3&)> material_W = nullptr)
      : X_WB{Vec3(0.3, -0.2, 0.1), RotationExp(Vec3(0.3, 0.5, -0.4))},
        samples(Bur::Ball(kRadius).Samples(count)),
        solid(MeshOf(X_WB.Inverse()),
              {.spacing = spacing, .most_bytes = 256u << 20, .material = InB(material_W)}, "block"),
        cut(solid, 256u << 20, "block"),
        rows(count) {
    materials.fill(kHard);
    materials[1] = kSoft;
  }
  static TriangleMesh MeshOf(const Pose& X_BW) {
    TriangleMesh mesh = MakeBox(Vec3(2.4e-3, 1.6e-3, 0.8e-3));
    for (Vec3& v : mesh.vertices) v = X_BW * (v - Vec3(0, 0, 0.4e-3));
    return mesh;
  }
  std::function<std::uint8_t(const Vec3&)> InB(std::function<std::uint8_t(const Vec3&)> of_W) {
    if (!of_W) return nullptr;
    return [of_W, X = X_WB](const Vec3& p_B) { return of_W(X * p_B); };
  }

  void Build() {
    rows.Clear();
    rows.AddSolid({samples, {bur, Quat::Identity()}, bur, kStiffness, 0.03, dt}, cut, X_WB,
                  materials);
  }
  /// Steps the bur on its spring towards the hand; returns what the rows report as cut.
  test::CutOfRows Step(const Vec3& hand) {
    Build();
    const Vec3 way = hand - bur;
    const double t[6] = {way.x(), way.y(), way.z()};  // a ball's rows do not turn it
    Energy* const energy = &rows;
    const QpResult step = solver.Solve(ActiveKernels(), t, {}, {&energy, 1}, guess, {});
    EXPECT_EQ(step.status, QpStatus::kSolved);
    std::copy(step.x, step.x + 6, guess);
    const test::CutOfRows said(rows, guess);
    EXPECT_GE(said.work, -1e-30);  // rounding of x
    const Vec3 v(guess[0], guess[1], guess[2]);
    const Pose X_BW = X_WB.Inverse();
    cut.Remove(Bur::Ball(kRadius), X_BW * Pose{bur, Quat::Identity()}, X_BW.q * v);
    bur += v;
    force = kStiffness * (bur - hand);
    return said;
  }
  /// Outward normal of a row's sample.
  Vec3 Normal(int i) const {
    return -Vec3(rows.yielding.rows.a[0][i], rows.yielding.rows.a[1][i],
                 rows.yielding.rows.a[2][i]);
  }

  Pose X_WB;
  std::vector<BurSample> samples;
  SolidGrid solid;
  CutField cut;
  CutRows rows;
  EnergySolver solver{16, 1024};
  std::array<Material, SolidGrid::kMaterials> materials;
  Vec3 bur = Vec3(0, 0, kRadius + 20e-6), force = Vec3::Zero();
  double guess[6] = {};
  double dt = 1e-3;
};

TEST(CutRows, RowOfASampleIsTheDistanceAheadOfIt) {
  Trial candidate;
  candidate.bur = Vec3(0, 0, kRadius + 10e-6);
  candidate.Build();
  ASSERT_GT(candidate.rows.count(), 0);
  for (int i = 0; i < candidate.rows.count(); ++i) {
    const Vec3 n = candidate.Normal(i);
    EXPECT_LT(n.z(), 0.0);  // samples that face up have nothing ahead
    // From the sample along n to the face.
    EXPECT_NEAR(-candidate.rows.yielding.rows.b[i], (candidate.bur + kRadius * n).z() / -n.z(),
                1e-8);
    const double area = 4.0 * kPi * kRadius * kRadius / 256;
    EXPECT_NEAR(candidate.rows.area()[i], area, 1e-4 * area);
    EXPECT_NEAR(candidate.rows.yielding.threshold[i], candidate.rows.area()[i] * 2e6 / kStiffness,
                1e-15);
    EXPECT_NEAR(candidate.rows.yielding.weight[i],
                candidate.rows.area()[i] * 0.5e9 / 1e-3 / kStiffness, 1e-12);
    // A ball about its own centre has no lever.
    for (std::size_t r = 3; r < 6; ++r)
      EXPECT_NEAR(candidate.rows.yielding.rows.a[r][i], 0.0, 1e-12);
  }
}

TEST(CutRows, TurnsAboutTheReference) {
  Trial candidate;
  candidate.bur = Vec3(0, 0, kRadius);
  const Vec3 reference(0.01, 0.02, 0.05);
  candidate.rows.AddSolid(
      {candidate.samples, {candidate.bur, Quat::Identity()}, reference, kStiffness, 0.03, 1e-3},
      candidate.cut, candidate.X_WB, candidate.materials);
  ASSERT_GT(candidate.rows.count(), 0);
  for (int i = 0; i < candidate.rows.count(); ++i) {
    const Vec3 n = candidate.Normal(i);
    const Vec3 turn(-candidate.rows.yielding.rows.a[3][i], -candidate.rows.yielding.rows.a[4][i],
                    -candidate.rows.yielding.rows.a[5][i]);
    EXPECT_LT((turn - (candidate.bur + kRadius * n - reference).cross(n) / 0.03).norm(), 1e-9);
  }
}

TEST(CutRows, PlungeHasTheLawsForceAndWork) {
  const double disc = kPi * kRadius * kRadius;
  for (const double dt : {1e-3, 0.25e-3}) {
    Trial candidate(50e-6, 1024);
    candidate.dt = dt;
    Vec3 hand = candidate.bur;
    const double whole = test::TotalLeft(candidate.cut);
    double rows_volume = 0.0, work = 0.0, law_work = 0.0, worst_change = 0.0;
    while (candidate.bur.z() > -0.4e-3) {
      hand.z() -= 2e-3 * dt;
      const double z = candidate.bur.z(), force = candidate.force.z();
      const test::CutOfRows step = candidate.Step(hand);
      rows_volume += step.volume;
      if (z > 0.0) continue;
      // The half sphere ahead at speed u: p0 pi R^2 + kappa u 2/3 pi R^2.
      const double law = disc * (2e6 + 0.5e9 * (z - candidate.bur.z()) / dt * 2.0 / 3.0);
      EXPECT_NEAR(candidate.force.z(), law, 0.005 * law);
      worst_change = std::max(worst_change, std::abs(candidate.force.z() - force) * 1e-3 / dt);
      work += kStiffness * step.work;
      law_work += law * (z - candidate.bur.z());
    }
    EXPECT_LT(worst_change, 0.004);
    const double removed = whole - test::TotalLeft(candidate.cut);
    EXPECT_NEAR(rows_volume, removed, 0.01 * removed);
    EXPECT_NEAR(work, law_work, 0.005 * law_work);
  }
}

TEST(CutRows, VolumeOfRowsIsThatOfTheGridAlsoBesideAnOlderCut) {
  Trial candidate;
  const Pose X_BW = candidate.X_WB.Inverse();
  for (int n = 0; n < 100; ++n) {
    candidate.cut.Remove(Bur::Ball(kRadius),
                         X_BW * Pose{Vec3(-0.9e-3 + 18e-6 * n, 0.3e-3, -0.05e-3), {}},
                         X_BW.q * Vec3(18e-6, 0, 0));
  }
  Vec3 hand(-0.6e-3, 0, kRadius + 10e-6);
  candidate.bur = hand;
  const double older = test::TotalLeft(candidate.cut);
  double rows_volume = 0.0;
  while (hand.x() < 0.6e-3) {
    (hand.z() > -0.4e-3 ? hand.z() : hand.x()) += hand.z() > -0.4e-3 ? -2e-6 : 3e-6;
    rows_volume += candidate.Step(hand).volume;
  }
  const double removed = older - test::TotalLeft(candidate.cut);
  EXPECT_NEAR(rows_volume, removed, 0.02 * removed);
}

TEST(CutRows, EachSampleHasTheMaterialThatLiesAheadOfIt) {
  Trial candidate(50e-6, 256, [](const Vec3& p_W) { return std::uint8_t(p_W.x() > 0.0 ? 1 : 0); });
  candidate.bur = Vec3(0, 0, -0.3e-3);
  candidate.Step(candidate.bur);
  candidate.Build();
  ASSERT_GT(candidate.rows.count(), 200);
  for (int i = 0; i < candidate.rows.count(); ++i) {
    const double x = candidate.Normal(i).x() * (kRadius + 25e-6);
    if (std::abs(x) < 45e-6) continue;
    const double pressure =
        candidate.rows.yielding.threshold[i] * kStiffness / candidate.rows.area()[i];
    EXPECT_NEAR(pressure, x > 0.0 ? kSoft.cutting_pressure : kHard.cutting_pressure, 1.0);
  }
}

}  // namespace
}  // namespace palpate
