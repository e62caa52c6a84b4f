#include "tests/support/contact_judge.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr double kDelta = 1e-6;     // what a step keeps [m]
constexpr double kLength = 0.0316;  // sqrt(k_r / k_t) [m]
constexpr double kNone = 5e-5;      // some millionths of the loads [N, N m]

/// A flat sheet at y = 0, seen from above, of rows of cells with the given widths.
TriangleMesh Sheet(const std::vector<double>& x, const std::vector<double>& z) {
  TriangleMesh mesh;
  for (const double p : x) {
    for (const double q : z) mesh.vertices.push_back({p, 0.0, q});
  }
  const auto n = static_cast<std::uint32_t>(z.size());
  for (std::uint32_t i = 0; i + 1 < x.size(); ++i) {
    for (std::uint32_t k = 0; k + 1 < n; ++k) {
      const std::uint32_t a = i * n + k, b = a + 1, c = b + n, d = a + n;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

std::vector<double> Even(double low, double high, int cells) {
  std::vector<double> at;
  for (int i = 0; i <= cells; ++i) at.push_back(low + (high - low) * i / cells);
  return at;
}

/// A roof or a groove along z: two flat sides that fall (or rise) by 45 degrees from the y axis.
TriangleMesh Fold(double side) {
  TriangleMesh mesh = Sheet({-0.05, 0.0, 0.05}, {-0.05, 0.05});
  for (Vec3& v : mesh.vertices) v.y() = side * std::abs(v.x());
  return mesh;
}

TriangleMesh Moved(TriangleMesh mesh, const Pose& X) {
  for (Vec3& v : mesh.vertices) v = X * v;
  return mesh;
}

Quat About(const Vec3& axis, double degrees) {
  return RotationExp(degrees * std::numbers::pi / 180.0 * axis);
}

Wrench Pull(const Vec3& force, const Vec3& torque = Vec3::Zero()) {
  return {force, torque};
}

const Vec3 kBlock(0.013, 0.010, 0.011);
/// A block that lies flat at y = 0, at the separation of a tool at rest.
Pose Flat(double x = 0.0) {
  return {Vec3(x, 0.5 * kBlock.y() + kDelta, 0.0)};
}

struct BlockOn {
  explicit BlockOn(TriangleMesh sheet, double mu = 0.0) : sheet_(std::move(sheet)) {
    ContactJudge::Object object{&sheet_};
    if (mu > 0.0) object.static_friction = [mu](const Vec3&) { return mu; };
    judge =
        std::make_unique<ContactJudge>(ContactJudge::Tool{.mesh = &block_}, std::vector{object});
  }
  std::unique_ptr<ContactJudge> judge;

 private:
  TriangleMesh block_ = MakeBox(kBlock), sheet_;
};

TEST(ContactJudge, FindsThatAPlateBearsWhatPressesOnIt) {
  const BlockOn on(Sheet(Even(-0.05, 0.05, 1), Even(-0.05, 0.05, 1)));
  const auto verdict = on.judge->Judge(Flat(), Pull({0, -3, 0}, {0.005, 0, -0.01}), kLength);
  EXPECT_LT(verdict.force, kNone);
  EXPECT_LT(verdict.torque, kNone);
  EXPECT_GE(verdict.contacts, 4u);
}

TEST(ContactJudge, FindsThatAPlateBearsNothingSideways) {
  const BlockOn on(Sheet(Even(-0.05, 0.05, 1), Even(-0.05, 0.05, 1)));
  const auto verdict = on.judge->Judge(Flat(), Pull({14.7, -3, 2}, {0, 0.25, 0}), kLength);
  EXPECT_NEAR(verdict.force, std::hypot(14.7, 2.0), kNone);
  EXPECT_NEAR(verdict.torque, 0.25, kNone) << "about the normal nothing holds it either";
}

TEST(ContactJudge, FindsThatNothingBearsWhatLiftsOrFloats) {
  const BlockOn on(Sheet(Even(-0.05, 0.05, 1), Even(-0.05, 0.05, 1)));
  EXPECT_NEAR(on.judge->Judge(Flat(), Pull({0, 2, 0}), kLength).force, 2.0, kNone);
  Pose X = Flat();
  X.p.y() += 4e-6;
  EXPECT_NEAR(on.judge->Judge(X, Pull({0, -2, 0}), kLength).force, 2.0, kNone);
  EXPECT_EQ(on.judge->Judge(X, Pull({0, -2, 0}), kLength).contacts, 0u);
}

TEST(ContactJudge, FindsByHowMuchABlockThatIsPulledOutsideOfItsFeetTips) {
  const BlockOn on(Sheet(Even(-0.05, 0.05, 1), Even(-0.05, 0.05, 1)));
  for (const double at : {0.0064, 0.0066, 0.009, 0.03}) {
    const auto verdict = on.judge->Judge(Flat(), Pull({0, -3, 0}, {0, 0, -3 * at}), kLength);
    // All of it on the feet at x = 6.5 mm: (1, at) less the projection on (1, 6.5 mm).
    const double foot = 0.5 * kBlock.x() / kLength, pulled = at / kLength;
    const double load = at < 0.0065 ? 1.0 : (1 + foot * pulled) / (1 + foot * foot);
    EXPECT_NEAR(verdict.force, 3 * std::abs(1 - load), kNone) << at;
    EXPECT_NEAR(verdict.torque, at < 0.0065 ? 0.0 : 3 * kLength * (pulled - load * foot), kNone)
        << at;
  }
}

TEST(ContactJudge, GivesABlockAtARimTheFeetThatAreOnThePlate) {
  const BlockOn on(MakeBox({0.04, 0.02, 0.04}));
  Pose X = Flat(0.020);  // half of it beyond the rim at x = 20 mm
  X.p.y() += 0.01;
  EXPECT_LT(on.judge->Judge(X, Pull({0, -3, 0}, {0, 0, 3 * 0.001}), kLength).torque, kNone);
  EXPECT_GT(on.judge->Judge(X, Pull({0, -3, 0}, {0, 0, -3 * 0.001}), kLength).torque, 0.001);
}

/// What the two sides of a right-angled cone about -y leave of a force in the plane of x and y.
double LeftOfRightAngle(const Vec3& force) {
  const double across = std::abs(force.x()) - std::max(0.0, -force.y());
  if (across <= 0.0) return 0.0;
  return force.y() > 0.0 && std::abs(force.x()) < force.y() ? force.norm()
                                                            : across / std::numbers::sqrt2;
}

TEST(ContactJudge, FindsThatAGrooveBearsWhatLiesBetweenItsNormals) {
  const TriangleMesh groove = Fold(1.0), block = MakeBox({0.01, 0.01, 0.01});
  const ContactJudge judge({.mesh = &block}, {{&groove}});
  // On its edge, and both faces 1 um from the sides.
  const Pose X{Vec3(0.0, 0.005 * std::numbers::sqrt2 + kDelta * std::numbers::sqrt2, 0.0),
               About(Vec3::UnitZ(), 45.0)};
  for (const Vec3& force : {Vec3(0, -3, 0), Vec3(2.9, -3, 0), Vec3(4, -3, 0), Vec3(-5, -1, 0)}) {
    const auto verdict = judge.Judge(X, Pull(force), kLength);
    EXPECT_NEAR(verdict.force, LeftOfRightAngle(force), kNone) << force.transpose();
    EXPECT_NEAR(verdict.torque, 0.0, kNone) << force.transpose();
  }
  EXPECT_NEAR(judge.Judge(X, Pull({0, -3, 2}), kLength).force, 2.0, kNone) << "along the groove";
}

TEST(ContactJudge, GivesCrossedEdgesTheirCommonNormal) {
  const TriangleMesh roof = Fold(-1.0), block = MakeBox({0.01, 0.01, 0.03});
  const ContactJudge judge({.mesh = &block}, {{&roof}});
  for (const double degrees : {90.0, 60.0, 5.0, 1.0}) {
    const Pose X{Vec3(0.0, 0.005 * std::numbers::sqrt2 + kDelta, 0.0),
                 About(Vec3::UnitY(), degrees) * About(Vec3::UnitZ(), 45.0)};
    const auto verdict = judge.Judge(X, Pull({1, -3, 2}), kLength);
    EXPECT_EQ(verdict.contacts, 1u) << degrees;
    EXPECT_NEAR(verdict.force, std::hypot(1.0, 2.0), kNone) << degrees;
    EXPECT_NEAR(verdict.torque, 0.0, kNone) << degrees;
    EXPECT_GT(judge.Judge(X, Pull({0, -3, 0}, {0.01, 0, 0}), kLength).torque, 0.005) << "a point";
  }
}

TEST(ContactJudge, GivesACornerAtAnEdgeTheDirectionsBetweenItsFaces) {
  const TriangleMesh roof = Fold(-1.0), block = MakeBox({0.01, 0.01, 0.01});
  const ContactJudge judge({.mesh = &block}, {{&roof}});
  // The corner (-, -, -) turned down, 1 um over the ridge.
  const Quat q = RotationBetween(Vec3(-1, -1, -1), -Vec3::UnitY());
  const Pose X{q * Vec3(0.005, 0.005, 0.005) + Vec3(0.0, kDelta, 0.0), q};
  const auto through_the_corner = [&](const Vec3& force) {
    return Pull(force, (-(q * Vec3(0.005, 0.005, 0.005))).cross(force));
  };
  EXPECT_LT(judge.Judge(X, through_the_corner({0, -3, 0}), kLength).force, kNone);
  EXPECT_LT(judge.Judge(X, through_the_corner({1.2, -2, 0}), kLength).force, kNone);
  EXPECT_GT(judge.Judge(X, through_the_corner({4, -2, 0}), kLength).force, 0.5);
  EXPECT_NEAR(judge.Judge(X, through_the_corner({0, -3, 1}), kLength).force, 1.0, 0.05);
}

TEST(ContactJudge, GivesACornerInAShallowValleyBothSides) {
  // 1 um above both sides, a corner is over both within 1 um times their slope only; right over
  // the bottom it is over neither's inside.
  const TriangleMesh block = MakeBox({0.01, 0.01, 0.01});
  for (const double slope : {0.035, 0.003}) {
    TriangleMesh valley = Sheet({-0.05, 0.0, 0.05}, {-0.05, 0.05});
    for (Vec3& v : valley.vertices) v.y() = slope * std::abs(v.x());
    const ContactJudge judge({.mesh = &block}, {{&valley}});
    const Quat q = RotationBetween(Vec3(-1, -1, -1), -Vec3::UnitY());
    const Vec3 lever = -(q * Vec3(0.005, 0.005, 0.005));
    for (const double off : {0.0, 1e-7, -5e-7}) {
      const Pose X{Vec3(off, kDelta, 0.0) - lever, q};
      for (const double aside : {0.0, 2.9 * slope, -2.9 * slope}) {
        const Vec3 force(aside, -3, 0);
        EXPECT_LT(judge.Judge(X, Pull(force, lever.cross(force)), kLength).force, 1e-3)
            << slope << ' ' << off;
      }
      const Vec3 beyond(0.5, -3, 0);
      EXPECT_NEAR(judge.Judge(X, Pull(beyond, lever.cross(beyond)), kLength).force,
                  (0.5 - slope * 3) / std::hypot(1.0, slope), 0.01)
          << slope << ' ' << off;
    }
  }
}

TEST(ContactJudge, FindsThatAWedgeHoldsNoMoreThanItsNormals) {
  // A ball between two sheets that lean towards each other.
  const double radius = 0.004;
  const TriangleMesh sheet = Sheet({-0.05, 0.05}, {-0.05, 0.05});
  for (const double degrees : {5.0, 30.0, 60.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vec3 left(std::cos(angle), std::sin(angle), 0.0), right(-left.x(), left.y(), 0.0);
    const auto behind = [&](const Vec3& n) {
      return Pose{-(radius + kDelta) * n, RotationBetween(Vec3::UnitY(), n)};
    };
    const ContactJudge judge({.radius = radius}, {{&sheet, behind(left)}, {&sheet, behind(right)}});
    const auto force = [&](const Vec3& pull) { return judge.Judge({}, Pull(pull), kLength).force; };
    EXPECT_GE(judge.ContactsAt({}).size(), 2u) << degrees;
    EXPECT_LT(force({0, -3, 0}), 3e-4) << degrees << ", with loads up to 17 N";
    EXPECT_LT(force(-4 * left - 0.1 * right), 3e-4) << degrees;
    // Beyond one sheet's normal nothing bears what lies along that sheet.
    const Vec3 along(-left.y(), left.x(), 0.0);
    EXPECT_NEAR(force(-4 * left + along), 1.0, 3e-4) << degrees;
    EXPECT_NEAR(force(along), 1.0, 3e-4) << degrees;
  }
}

TEST(ContactJudge, GivesABallItsNearestPlacesAndNoTorque) {
  const TriangleMesh box = MakeBox(Vec3::Constant(0.05));
  const double r = 0.005;
  const ContactJudge judge({.radius = r}, {{&box}});
  const Pose on_top{Vec3(0.003, 0.025 + r + kDelta, 0.004), About(Vec3::UnitX(), 70)};
  EXPECT_LT(judge.Judge(on_top, Pull({0, -3, 0}), kLength).force, kNone);
  EXPECT_NEAR(judge.Judge(on_top, Pull({1, -3, 2}), kLength).force, std::hypot(1.0, 2.0), kNone);
  const Vec3 out = Vec3(1, 2, 0).normalized();
  const Pose at_edge{Vec3(0.025, 0.025, 0.004) + (r + kDelta) * out};
  EXPECT_LT(judge.Judge(at_edge, Pull(-3 * out), kLength).force, 3e-3) << "1 um over 5 mm";
  EXPECT_NEAR(judge.Judge(at_edge, Pull({-3, 0, 0}), kLength).force, 3 * out.y(), 3e-3);
}

TEST(ContactJudge, GivesFrictionItsCone) {
  const BlockOn on(Sheet(Even(-0.05, 0.05, 3), Even(-0.05, 0.05, 3)), 0.5);
  for (int k = 0; k < 10; ++k) {
    const double angle = 0.1 + 0.6 * k;
    const Vec3 along(std::cos(angle), 0, std::sin(angle));
    EXPECT_LT(on.judge->Judge(Flat(), Pull(Vec3(0, -3, 0) + 1.499 * along), kLength).force, kNone);
    const double more = on.judge->Judge(Flat(), Pull(Vec3(0, -3, 0) + 2.5 * along), kLength).force;
    // Less the pyramid's corners; more loads tip the block no more than they bear.
    EXPECT_NEAR(more, 1.0 / std::hypot(1.0, 0.5), 0.02);
    EXPECT_LT(on.judge->Judge(Flat(), Pull({0, -3, 0}, {0, 0.002, 0}), kLength).torque, kNone);
    EXPECT_GT(on.judge->Judge(Flat(), Pull({0, -3, 0}, {0, 0.1, 0}), kLength).torque, 0.05);
  }
}

TEST(ContactJudge, FindsTheSameInATurnedWorld) {
  Random random(3);
  const TriangleMesh block = MakeBox(kBlock);
  for (int trial = 0; trial < 30; ++trial) {
    const TriangleMesh sheet =
        Sheet(Even(-0.05, 0.05, 1 + random.Below(9)), Even(-0.05, 0.05, 1 + random.Below(9)));
    const Pose X_VW{random.InCube(0.3), random.Rotation()};
    const Pose X = Flat(random.Uniform(-0.02, 0.02)) * Pose{Vec3::Zero(), About(Vec3::UnitY(), 7)};
    const Vec3 force = random.InCube(3.0), torque = random.InCube(0.05);
    ContactJudge::Object still{&sheet}, moved{&sheet, X_VW};
    if (trial % 2 == 0) {
      still.static_friction = moved.static_friction = [](const Vec3&) { return 0.3; };
    }
    const ContactJudge one({.mesh = &block}, {still}), other({.mesh = &block}, {moved});
    const auto a = one.Judge(X, Pull(force, torque), kLength);
    const auto b = other.Judge(X_VW * X, Pull(X_VW.q * force, X_VW.q * torque), kLength);
    // The pyramid round a cone of friction does not turn with the world.
    const double off = trial % 2 == 0 ? 0.01 : 1e-7;
    EXPECT_NEAR(a.force, b.force, off * force.norm()) << trial;
    EXPECT_NEAR(a.torque, b.torque, off * std::max(torque.norm(), kLength * force.norm())) << trial;
  }
}

/// A flat sheet in some tessellation: strips, cells from 1 nm to 10 mm, a fan of needles, repeated
/// triangles, corners that coincide without being shared, and a T-junction on each of its seams.
TriangleMesh Tessellated(int kind, Random& random) {
  const auto uneven = [&] {
    std::vector<double> at{-0.05};
    while (at.back() < 0.05) {
      at.push_back(at.back() + std::pow(10.0, random.Uniform(-9.0, -2.0)) + 1e-3 * random.Below(2));
    }
    return at;
  };
  switch (kind) {
    case 0:
      return Sheet(Even(-0.04, 0.04, 80), {-0.05, 0.05});
    case 1:
      return Sheet(uneven(), {-0.05, 0.05});
    case 2:
      return Sheet(Even(-0.05, 0.05, 30), Even(-0.05, 0.05, 30));
    case 3: {  // a fan
      TriangleMesh mesh{{Vec3(random.Uniform(-0.01, 0.01), 0.0, random.Uniform(-0.01, 0.01))}, {}};
      constexpr std::uint32_t kCorners = 48;
      for (std::uint32_t i = 0; i < kCorners; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kCorners;
        mesh.vertices.push_back({0.05 * std::cos(angle), 0.0, 0.05 * std::sin(angle)});
        mesh.triangles.push_back({0, 1 + (i + 1) % kCorners, 1 + i});
      }
      return mesh;
    }
    case 4: {  // nothing shared, everything twice
      const TriangleMesh from = Sheet(Even(-0.05, 0.05, 9), Even(-0.05, 0.05, 9));
      TriangleMesh mesh;
      for (int twice = 0; twice < 2; ++twice) {
        for (const auto& t : from.triangles) {
          const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
          for (const std::uint32_t v : t) mesh.vertices.push_back(from.vertices[v]);
          mesh.triangles.push_back({first, first + 1, first + 2});
        }
      }
      return mesh;
    }
    default: {  // strips whose seams have corners of the one side alone
      TriangleMesh mesh;
      for (int i = 0; i < 20; ++i) {
        const TriangleMesh strip =
            Sheet({-0.05 + 0.005 * i, -0.05 + 0.005 * (i + 1)}, Even(-0.05, 0.05, 3 + i % 4));
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), strip.vertices.begin(), strip.vertices.end());
        for (const auto& [a, b, c] : strip.triangles) {
          mesh.triangles.push_back({a + first, b + first, c + first});
        }
      }
      return mesh;
    }
  }
}

TEST(ContactJudge, FeelsNoTessellationOfAPlane) {
  Random random(5);
  const TriangleMesh block = MakeBox(kBlock);
  for (int trial = 0; trial < 60; ++trial) {
    const Pose tilt = trial % 2 == 0 ? Pose{} : Pose{random.InCube(0.05), random.Rotation()};
    const TriangleMesh sheet = Moved(Tessellated(trial % 6, random), tilt);
    const ContactJudge judge({.mesh = &block}, {{&sheet}});
    // A tool at rest leans by up to half a micrometre over its size.
    const Quat lean = RotationExp(random.InCube(0.4e-6 / 0.013));
    const Pose X = tilt * Pose{Flat(random.Uniform(-0.01, 0.01)).p,
                               About(Vec3::UnitY(), random.Uniform(0.0, 360.0)) * lean};
    const Vec3 down = tilt.q * Vec3(0, -3, 0), aside = tilt.q * Vec3(2, 0, 1);
    const auto borne = judge.Judge(X, Pull(down), kLength);
    EXPECT_LT(borne.force, 1e-3) << trial;
    EXPECT_LT(borne.torque, 1e-3 * kLength) << trial;
    const auto not_borne = judge.Judge(X, Pull(down + aside), kLength);
    EXPECT_NEAR(not_borne.force, aside.norm(), 1e-3) << trial;
    for (const ContactJudge::Contact& contact : judge.ContactsAt(X)) {
      EXPECT_GT(contact.normal_W.dot(-down) / 3.0, 1.0 - 1e-8) << trial;
    }
  }
}

TEST(ContactJudge, SeesThatABlockStuckOnStripsIsHeldByNothing) {
  // A block leans by 24 urad; its front edge is 0.4953 um above strips of 1 mm, just behind a seam.
  // A plane across the nearest points of that edge and the next strip once held it with 14.7 N.
  const BlockOn on(Sheet(Even(-0.04, 0.04, 80), {-0.05, 0.05}));
  const double angle = -24e-6, half = 0.5 * kBlock.x();
  Pose X{Vec3(0.004 - 1e-7 - half, 0.0, 0.0), RotationExp(angle * Vec3::UnitZ())};
  X.p.y() = 0.5 * kBlock.y() + 0.4953e-6 - angle * half;
  const auto verdict = on.judge->Judge(X, Pull({14.7, -3, 0}), kLength);
  EXPECT_NEAR(verdict.force, 14.7, 1e-3);
  EXPECT_LT(on.judge->Judge(X, Pull({0, -3, 0}), kLength).force, 1e-3);
}

TEST(ContactJudge, TakesTheSpringsPullFromThePosesAlone) {
  Random random(8);
  const Coupling coupling{.stiffness = 800.0, .torsional_stiffness = 0.7};
  const Vec3 reference(0.01, -0.02, 0.03);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 turn = random.Uniform(0.0, 6.0) * random.Direction(), way = random.InCube(0.02);
    const Pose X_WG{random.InCube(0.1), random.Rotation()};
    Pose X_WH{Vec3::Zero(), RotationExp(turn) * X_WG.q};
    X_WH.p = X_WG * reference + way - X_WH.q * reference;
    const Wrench published{-800.0 * way, -0.7 * 0.9 * turn};
    const Wrench pull = SpringPull(X_WG, X_WH, reference, coupling, published);
    EXPECT_LT((pull.force - 800.0 * way).norm(), 1e-9) << trial;
    EXPECT_LT((pull.torque - 0.7 * turn).norm(), 1e-9) << turn.norm() << ", past half a turn too";
  }
}

}  // namespace
}  // namespace palpate::test
