#include "tests/support/curved_bodies.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/support/dirty_mesh.h"

namespace palpate::test {
namespace {

template <class Check>
void ForEachBody(Check check) {
  for (const std::string_view kind : kCurvedKinds) {
    for (const std::size_t triangles : {1000u, 10'000u}) {
      SCOPED_TRACE(std::string(kind) + " of " + std::to_string(triangles));
      Random random(triangles);
      check(CurvedBody(kind, triangles, random), triangles, random);
    }
  }
}

TEST(CurvedBodies, AreSolidsOfAboutSoManyTriangles) {
  ForEachBody([](const CurvedBody& body, std::size_t triangles, Random&) {
    const MeshReport report = InspectMesh(body.mesh());
    EXPECT_TRUE(report.solid());
    EXPECT_GT(report.volume, 0.0);
    EXPECT_GT(report.triangles, 0.8 * triangles);
    EXPECT_LT(report.triangles, 2.1 * triangles);
  });
}

TEST(CurvedBodies, FindTheNearestPointOfTheirSurface) {
  ForEachBody([](const CurvedBody& body, std::size_t, Random& random) {
    for (int i = 0; i < 100; ++i) {
      Vec3 along;
      const CurvedBody::Point on = body.Start(i % 2 == 0, along, random);
      EXPECT_NEAR(along.dot(on.normal), 0.0, 1e-12);
      const double off = random.Uniform(-3e-3, 6e-3);
      const CurvedBody::Point found = body.Nearest(on.at + off * on.normal);
      EXPECT_LT((found.at - on.at).norm(), 1e-12);
      EXPECT_LT((found.normal - on.normal).norm(), 1e-9);
      // The surface curves as it says: a chord's height is s^2 / 2 times the curvature.
      const double s = 1e-4;
      const Vec3 beside = on.at + s * along;
      const double curved = 2.0 * (beside - body.Nearest(beside).at).dot(on.normal) / (s * s);
      EXPECT_LT(curved, body.greatest_curvature() * 1.01);
      EXPECT_GT(curved,
                body.least_curvature() * (body.least_curvature() < 0.0 ? 1.01 : 0.99) - 0.01);
    }
  });
}

TEST(CurvedBodies, AreNowhereFartherFromTheirMeshThanTheySay) {
  ForEachBody([](const CurvedBody& body, std::size_t, Random& random) {
    double sagitta = 0.0, angle = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      const auto t =
          static_cast<std::size_t>(random.Below(static_cast<int>(body.mesh().triangles.size())));
      const Vec3 a = Corner(body.mesh(), t, 0), b = Corner(body.mesh(), t, 1) - a,
                 c = Corner(body.mesh(), t, 2) - a;
      const double u = random.Uniform(0.0, 1.0), v = random.Uniform(0.0, 1.0 - u);
      const Vec3 p = a + u * b + v * c, facet = b.cross(c).normalized();
      const CurvedBody::Point on = body.Nearest(p);
      if (std::abs(facet.z()) > 0.999 && std::abs(on.normal.z()) < 1e-9) continue;  // a lid
      sagitta = std::max(sagitta, (p - on.at).norm());
      angle = std::max(angle, std::acos(std::min(1.0, facet.dot(on.normal))));
    }
    EXPECT_LT(sagitta, body.sagitta());
    EXPECT_GT(sagitta, 0.5 * body.sagitta());
    EXPECT_LT(angle, body.facet_angle() * 1.02);
    EXPECT_GT(angle, 0.8 * body.facet_angle());
  });
}

}  // namespace
}  // namespace palpate::test
