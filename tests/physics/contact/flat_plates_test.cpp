// A box on plates whose top is flat, however it is divided: what it feels there is known.
#include "tests/support/flat_plates.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/physics/contact/contact_scenes.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::MakeMeshBody;

/// A closed plate, its top at y = 0, divided into cells across x and along z.
TriangleMesh MakeDividedPlate(std::uint32_t across, std::uint32_t along, double half) {
  TriangleMesh plate;
  const auto place = [half](std::uint32_t i, std::uint32_t n) {
    return half * (2.0 * i / n - 1.0);
  };
  for (const double y : {0.0, -0.01}) {
    for (std::uint32_t i = 0; i <= across; ++i) {
      for (std::uint32_t j = 0; j <= along; ++j) {
        plate.vertices.push_back({place(i, across), y, place(j, along)});
      }
    }
  }
  const std::uint32_t below = (across + 1) * (along + 1);
  const auto of = [along](std::uint32_t i, std::uint32_t j) { return i * (along + 1) + j; };
  const auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    plate.triangles.push_back({a, b, c});
    plate.triangles.push_back({a + below, c + below, b + below});
  };
  const auto wall = [&](std::uint32_t a, std::uint32_t b) {
    plate.triangles.push_back({a, a + below, b + below});
    plate.triangles.push_back({a, b + below, b});
  };
  for (std::uint32_t i = 0; i < across; ++i) {
    for (std::uint32_t j = 0; j < along; ++j) {
      face(of(i, j), of(i, j + 1), of(i + 1, j + 1));
      face(of(i, j), of(i + 1, j + 1), of(i + 1, j));
    }
    wall(of(i + 1, 0), of(i, 0));
    wall(of(i, along), of(i + 1, along));
  }
  for (std::uint32_t j = 0; j < along; ++j) {
    wall(of(0, j), of(0, j + 1));
    wall(of(across, j + 1), of(across, j));
  }
  return plate;
}

/// A box of 13 x 10 x 11 mm, pressed onto a plate and drawn along it.
struct Slide {
  explicit Slide(TriangleMesh plate, FrictionModel friction = FrictionModel::kOff) {
    scene.tools.push_back(MakeMeshBody("box", MakeBox(Vec3(0.013, 0.01, 0.011))));
    scene.objects.push_back(MakeMeshBody("plate", std::move(plate)));
    scene.objects.front().materials.front().static_friction = 0.5;
    scene.objects.front().materials.front().dynamic_friction = 0.3;
    scene.features = {.contact = ContactModel::kSurface, .friction = friction};
  }

  /// Calls judge(cycle, report) in each cycle, from one of which the hand is down and slides.
  /// @param to  where the slide ends [m]
  template <class Judge>
  void Go(const Vec3& from, const Vec3& to, double depth, double tremor, int cycles, Judge judge) {
    const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
    StepWorkspace workspace(model);
    StepState state(model);
    constexpr int kDown = 400;
    state.X_WG = state.X_WH = {from + Vec3(0.0, 0.006, 0.0), Quat::Identity()};
    for (int i = 0; i < kDown + cycles; ++i) {
      const double in = std::min(1.0, static_cast<double>(i) / kDown);
      const double part = std::max(0.0, static_cast<double>(i - kDown) / cycles);
      const double trembles = tremor * std::sin(2.0 * std::numbers::pi * 8e-3 * i);
      const double y = 0.005 - (-0.001 + in * (depth + 0.001)) + trembles;
      const Vec3 at = from + part * (to - from) + Vec3(0.0, y, 0.0);
      judge(i - kDown, HapticStep(model, {at, Quat::Identity()}, state, workspace));
    }
  }
  Scene scene;
};

double Sideways(const Vec3& force) {
  return std::hypot(force.x(), force.z());
}

// One separation for the triangle that touches and for the next one in the same plane.  When a face
// that left a few nanometres less than its neighbour's distance was refused, the box stuck.
TEST(FlatPlate, HoldsNoBoxBackThatSlidesWithoutFriction) {
  struct Case {
    std::uint32_t across, along;
    double half, depth, speed, x;
  };
  for (const Case& c : {Case{80, 1, 0.04, 0.003, 3.3e-6, 0.00071},
                        {80, 1, 0.04, 0.001, 1e-5, 3e-4},
                        {80, 1, 0.04, 0.04, 1e-5, 3e-4},
                        {30, 30, 0.05, 0.003, 3.3e-6, 0.00071}}) {
    SCOPED_TRACE(testing::Message() << c.across << " x " << c.along << ", " << c.depth
                                    << " m deep, " << c.speed << " m a cycle");
    const int cycles = std::min(3000, static_cast<int>(0.02 / c.speed));
    double most = 0.0;
    Slide(MakeDividedPlate(c.across, c.along, c.half))
        .Go(Vec3(c.x, 0, 0), Vec3(c.x + c.speed * cycles, 0, 0), c.depth, 20e-6, cycles,
            [&](int, const StepReport& report) {
              most = std::max(most, Sideways(report.wrench.force));
            });
    EXPECT_LE(most, limits::kStiffness * limits::mesh::kReleaseError);
  }
}

// All rows of a flat plate have one normal, and a face that carries more rows than it has freedoms
// has loads all the same: what it rubs with is Coulomb's.
TEST(FlatPlate, ResistsABoxByCoulombsLaw) {
  for (const double degrees : {5.7, 73.2, 185.7, 253.2}) {
    SCOPED_TRACE(testing::Message() << degrees << " degrees");
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vec3 from(0.0004, 0.0, 0.0007), along(std::cos(angle), 0.0, std::sin(angle));
    double least = 1.0, most = 0.0;
    int unsolved = 0;
    Slide(MakeDividedPlate(30, 30, 0.05), FrictionModel::kCoulomb)
        .Go(from, from + 0.012 * along, 0.001, 0.0, 3000, [&](int i, const StepReport& report) {
          unsolved += (report.faults & kFaultFriction) != 0;
          if (i < 1200) return;
          const double mu = Sideways(report.wrench.force) / report.wrench.force.y();
          least = std::min(least, mu);
          most = std::max(most, mu);
        });
    EXPECT_EQ(unsolved, 0);
    EXPECT_NEAR(least, 0.3, 1e-5);
    EXPECT_NEAR(most, 0.3, 1e-5);
  }
}

// Rows of some corners are too few: friction would tip the tool over those that no row holds.
// Rows within the foot are too many: the loads of a face have three freedoms.
TEST(FlatPlate, HoldsEachCornerOfABoxWithFrictionByOneRow) {
  const Vec3 size(0.011, 0.008, 0.013);
  const MovingBody tool{ContactMesh(MakeBox(size))};
  constexpr int kRows = 1024;
  test::Random random(7);
  for (const std::string_view tessellation : test::kTessellations) {
    SCOPED_TRACE(tessellation);
    const TriangleMesh plate = test::MakePlate(tessellation, random.Bits());
    const ContactBody object{std::make_shared<const ContactShape>(ContactMesh(plate)),
                             PlacementOf({})};
    BodyContact all(tool, {&object, 1}, kRows, limits::mesh::kSeparation,
                    limits::mesh::kMaxQueries);
    MeshContact& contact = all.of.front();
    for (int i = 0; i < 5; ++i) {
      SeparationFront front;
      ContactRows rows(kRows, 0.03);
      const Quat q = RotationExp(random.Uniform(-3.0, 3.0) * Vec3::UnitY());
      const RelativePose at(
          Vec3(random.Uniform(-0.01, 0.01), 0.5 * size.y() + 1e-6, random.Uniform(-0.01, 0.01)), q);
      // First it stands on one corner: only there are the patches split.
      const Quat tips = RotationExp(q * Vec3(1e-4, 0.0, 1e-4)) * q;
      const double higher = 0.5e-4 * (size.x() + size.z()) - 0.6e-6;
      for (const RelativePose& from : {RelativePose(at.p + higher * Vec3::UnitY(), tips), at}) {
        rows.Clear();
        FrameRows in_B(rows);
        all.queries = {.most = limits::mesh::kMaxQueries};
        BeginSubStep(contact, ActiveKernels(), front, from, {}, First::kAllCorners, in_B);
        EndSubStep(contact, true);
      }
      // Within an edge, a vertex of others ends faces, and is held, too.
      if (tessellation != "t-junctions") EXPECT_EQ(rows.count(), 4);
      for (const double x : {-0.5, 0.5}) {
        for (const double z : {-0.5, 0.5}) {
          const Vec3 corner = at.R * size.cwiseProduct(Vec3(x, -0.5, z));
          int found = 0;
          for (int row = 0; row < rows.count(); ++row) {
            found += (rows.lever(row) - corner).norm() < 1e-9;
            EXPECT_NEAR(rows.normal(row).y(), 1.0, 1e-9);
          }
          EXPECT_EQ(found, 1);
        }
      }
    }
  }
}

}  // namespace
}  // namespace palpate
