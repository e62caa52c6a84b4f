// A box on plates whose top is flat, however it is divided: what it feels there is known.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/physics/contact/contact_scenes.h"
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
TEST(FlatPlate, RubsOnABoxByCoulombsLaw) {
  for (const double degrees : {5.7, 73.2, 185.7, 253.2}) {
    SCOPED_TRACE(testing::Message() << degrees << " degrees");
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vec3 from(0.0004, 0.0, 0.0007), along(std::cos(angle), 0.0, std::sin(angle));
    double least = 1.0, most = 0.0, sum = 0.0;
    int unsolved = 0, judged = 0;
    Slide(MakeDividedPlate(30, 30, 0.05), FrictionModel::kCoulomb)
        .Go(from, from + 0.012 * along, 0.001, 0.0, 3000, [&](int i, const StepReport& report) {
          unsolved += (report.faults & kFaultFriction) != 0;
          if (i < 1200) return;
          const double mu = Sideways(report.wrench.force) / report.wrench.force.y();
          least = std::min(least, mu);
          most = std::max(most, mu);
          sum += mu;
          ++judged;
        });
    EXPECT_EQ(unsolved, 0);
    EXPECT_GE(least, 0.285);  // a cycle in which rows of two poses meet, and those after it
    EXPECT_LE(most, 0.3005);
    EXPECT_NEAR(sum / judged, 0.3, 3e-4);
  }
}

}  // namespace
}  // namespace palpate
