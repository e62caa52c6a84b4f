#include "scenes/mesh/ambient_light.h"

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"

namespace palpate {
namespace {

Body At(TriangleMesh mesh, const Vec3& p) {
  Body body;
  body.mesh = std::move(mesh);
  body.X_WB.p = p;
  return body;
}

TEST(AmbientLight, AConvexBodyAloneSeesTheWholeRoom) {
  std::vector<Body> bodies{At(MakeSphere(0.01, 1280), Vec3::Zero())};
  LightObjects(bodies);
  ASSERT_EQ(bodies[0].ambient.size(), bodies[0].mesh.vertices.size());
  for (const std::uint8_t share : bodies[0].ambient) EXPECT_GT(share, 250);
}

TEST(AmbientLight, APlateHidesHalfOfTheRoomFromWhatFacesIt) {
  // A wide plate hides the whole room from what faces it, and nothing from what faces away.
  std::vector<Body> bodies{At(MakeSphere(0.002, 1280), Vec3::Zero()),
                           At(MakeBox({0.2, 0.004, 0.2}), {0, 0.005, 0})};
  LightObjects(bodies);
  for (std::size_t v = 0; v < bodies[0].ambient.size(); ++v) {
    const double up = bodies[0].mesh.vertices[v].normalized().y();
    if (up > 0.9) {
      EXPECT_LT(bodies[0].ambient[v], 25);
    }
    if (up < -0.9) {
      EXPECT_GT(bodies[0].ambient[v], 240);
    }
    if (std::abs(up) < 0.05) {
      EXPECT_NEAR(bodies[0].ambient[v], 127, 40);
    }
  }
}

TEST(AmbientLight, WhatCanBeCutShadesNothing) {
  std::vector<Body> bodies{At(MakeSphere(0.002, 1280), Vec3::Zero()),
                           At(MakeBox({0.2, 0.004, 0.2}), {0, 0.005, 0})};
  bodies[1].grid.emplace();
  LightObjects(bodies);
  for (const std::uint8_t share : bodies[0].ambient) EXPECT_GT(share, 250);
}

}  // namespace
}  // namespace palpate
