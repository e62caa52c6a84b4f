// Compares rows between meshes with gaps in closed form: near the candidate it was made for, a row
// must match the contact's geometry.
#include <functional>
#include <memory>
#include <span>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/contact/sub_step.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

/// A box about the origin with the corner (-, -, -) as its lowest point, or upside down.
TriangleMesh BoxOnItsCorner(double size, bool upside_down) {
  TriangleMesh box = MakeBox(Vec3::Constant(size));
  const Quat turn = RotationBetween(Vec3(1.0, 1.1, 1.3), Vec3::UnitZ());
  for (Vec3& x : box.vertices) {
    x = turn * x;
    if (upside_down) x = Vec3(x.x(), -x.y(), -x.z());
  }
  return box;
}

Vec3 Extreme(const TriangleMesh& mesh, const Vec3& direction) {
  Vec3 best = mesh.vertices.front();
  for (const Vec3& x : mesh.vertices) {
    if (direction.dot(x - best) > 0.0) best = x;
  }
  return best;
}

/// Moves and turns a tool 40 um into an object, and compares the row with the gap near there.
/// @param gap  of the contact, at a position and rotation of the tool (its reference is its
/// origin).
void ExpectRowsLike(const TriangleMesh& tool_mesh, const TriangleMesh& object_mesh, double height,
                    const std::function<double(const Vec3& p, const Mat3& R)>& gap) {
  const MovingBody tool{ContactMesh(tool_mesh)};
  const ContactBody object{std::make_shared<const ContactShape>(ContactMesh(object_mesh)),
                           PlacementOf({})};
  constexpr int kRows = 64;
  BodyContact all(tool, {&object, 1}, kRows, limits::mesh::kSeparation, limits::mesh::kMaxQueries);
  MeshContact& contact = all.of.front();
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    SeparationFront front;
    ContactRows rows(kRows, 0.03);
    rows.Clear();
    FrameRows in_B(rows);
    const RelativePose from(
        Vec3(1e-4 * random.Uniform(-1.0, 1.0), 1e-4 * random.Uniform(-1.0, 1.0), height + 10e-6),
        RotationExp(0.1 * random.InCube(1.0)));
    // The same gap at every rotation of the tool.
    const double before = gap(from.p, from.R);
    const RelativePose at(from.p + Vec3(0.0, 0.0, 10e-6 - before), from.q);
    ASSERT_NEAR(gap(at.p, at.R), 10e-6, 3e-6);
    const Vec3 phi = 6e-3 * random.InCube(1.0);
    Vec3 v = 1e-5 * random.InCube(1.0);
    v.z() -= gap(at.p + v, RotationExp(phi) * at.R) + 40e-6;
    all.queries = {.most = limits::mesh::kMaxQueries};
    BeginSubStep(contact, ActiveKernels(), front, at, {}, First::kActive, in_B);
    ASSERT_FALSE(CheckCandidate(contact, v, phi, in_B));
    ASSERT_GT(rows.count(), 0);
    const auto exact = [&](const Vec3& dv, const Vec3& dphi) {
      return gap(at.p + v + dv, RotationExp(phi + dphi) * at.R);
    };
    for (int row = 0; row < rows.count(); ++row) {
      for (int k = 0; k < 10; ++k) {
        const Vec3 dv = 1e-8 * random.InCube(1.0), dphi = 1e-6 * random.InCube(1.0);
        const double grows = rows.Left(row, v + dv, phi + dphi) - rows.Left(row, v, phi);
        EXPECT_NEAR(grows, exact(dv, dphi) - exact(Vec3::Zero(), Vec3::Zero()), 2e-12)
            << "m, row " << row << " of " << rows.count() << ", try " << i;
      }
    }
  }
}

TEST(MeshRows, AreTrueOfACornerOfTheToolAboveAFace) {
  const TriangleMesh tool = BoxOnItsCorner(0.03, false);
  const Vec3 corner = Extreme(tool, -Vec3::UnitZ());
  ExpectRowsLike(tool, MakeBox(Vec3(0.2, 0.2, 0.02)), 0.01 - corner.z(),
                 [corner](const Vec3& p, const Mat3& R) { return (p + R * corner).z() - 0.01; });
}

TEST(MeshRows, AreTrueOfAFaceOfTheToolAboveACorner) {
  const TriangleMesh object = BoxOnItsCorner(0.03, true);
  const Vec3 corner = Extreme(object, Vec3::UnitZ());
  ExpectRowsLike(MakeBox(Vec3(0.2, 0.2, 0.02)), object, 0.01 + corner.z(),
                 [corner](const Vec3& p, const Mat3& R) {
                   const Vec3 up = R.col(2);
                   return -0.01 - up.dot(corner - p);
                 });
}

TEST(MeshRows, AreTrueOfEdgesThatCross) {
  // Bars with an edge at the bottom and one at the top, along x and along y.
  const auto bar = [](const Vec3& size, const Vec3& axis) {
    TriangleMesh mesh = MakeBox(size);
    for (Vec3& x : mesh.vertices) x = RotationExp(0.8 * axis) * x;
    return mesh;
  };
  const TriangleMesh tool = bar(Vec3(0.1, 0.01, 0.01), Vec3::UnitX());
  const TriangleMesh object = bar(Vec3(0.01, 0.1, 0.01), Vec3::UnitY());
  const Vec3 low = Extreme(tool, -Vec3::UnitZ()), high = Extreme(object, Vec3::UnitZ());
  ExpectRowsLike(tool, object, high.z() - low.z(), [low, high](const Vec3& p, const Mat3& R) {
    const Vec3 n = R.col(0).cross(Vec3::UnitY()).normalized();
    return n.dot(p + R * low - high);
  });
}

}  // namespace
}  // namespace palpate
