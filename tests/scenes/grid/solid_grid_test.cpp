#include "scenes/grid/solid_grid.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_query.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/complaint.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::Random;
using testing::AllOf;
using testing::HasSubstr;

TriangleMesh Turned(TriangleMesh mesh, const Quat& q, const Vec3& by = Vec3::Zero()) {
  for (Vec3& v : mesh.vertices) v = q * v + by;
  return mesh;
}

double BoxDistance(const Vec3& p, const Vec3& half) {
  const Vec3 q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

template <class Visit>
void EachPoint(const SparseField& field, Visit visit) {
  const Lattice& lattice = field.lattice();
  for (int k = 0; k < 8 * lattice.blocks[2]; ++k) {
    for (int j = 0; j < 8 * lattice.blocks[1]; ++j) {
      for (int i = 0; i < 8 * lattice.blocks[0]; ++i) {
        visit(lattice.Point(i, j, k), double(field.At(i, j, k)));
      }
    }
  }
}

// Every lattice point: beside faces, edges and corners, and far from them.
TEST(SolidGrid, OfABoxIsExactAtEveryPointHoweverItIsTurned) {
  const Vec3 half(0.9e-3, 0.6e-3, 0.45e-3);
  Random random(7);
  for (const Quat& q : {Quat::Identity(), random.Rotation(), random.Rotation()}) {
    const SolidGrid grid(Turned(MakeBox(2.0 * half), q), {.spacing = 50e-6}, "box");
    const double band = grid.field().band();
    int inside = 0;
    EachPoint(grid.field(), [&](const Vec3& p, double distance) {
      const double truth = std::clamp(BoxDistance(q.conjugate() * p, half), -band, band);
      ASSERT_NEAR(distance, truth, 2e-11) << p.transpose();
      inside += distance < 0.0;
    });
    EXPECT_NEAR(inside * std::pow(50e-6, 3), 8.0 * half.prod(), 0.02 * 8.0 * half.prod());
  }
}

// Lattice lines may run through vertices and along edges and faces.
TEST(SolidGrid, LinesThroughVerticesAndEdgesCrossNoOftenerThanOthers) {
  const double h = 100e-6, offset = (SolidGrid::kBandSpacings + 1 + 0.382) * h;
  // The lattice starts off the mesh's bounding box.  A small box beyond each of three sides extends
  // that box just so that the big box's corners, edges and diagonals fall on lattice points.
  TriangleMesh mesh = MakeBox(Vec3(10 * h, 10 * h, 10 * h));
  const Vec3 low = Vec3::Constant(-5 * h - offset);
  for (const int axis : {0, 1, 2}) {
    TriangleMesh moved = MakeBox(Vec3::Constant(h));
    const Vec3 at = low + Vec3::Constant(offset - 0.618 * h + 0.5 * h) - 2.0 * h * Vec3::Unit(axis);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3& v : moved.vertices) mesh.vertices.push_back(v + at);
    for (const auto& [a, b, c] : moved.triangles) {
      mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  const SolidGrid grid(mesh, {.spacing = h}, "box");
  EachPoint(grid.field(), [&](const Vec3& p, double distance) {
    const double truth = BoxDistance(p, Vec3::Constant(5 * h));
    if (std::abs(truth) > 1e-12 && std::abs(truth) < 2.0 * h && (p.array() > -4.9 * h).all()) {
      ASSERT_NEAR(distance, truth, 1e-10) << p.transpose();
    }
  });
}

TEST(SolidGrid, InterpolatesASphereTheBetterTheFinerItIs) {
  double last = 1e300;
  for (const double h : {200e-6, 100e-6, 50e-6}) {
    const double radius = 1e-3;
    const SolidGrid grid(MakeSphere(radius, 81920), {.spacing = h}, "sphere");
    Random random(8);
    double worst = 0.0;
    for (int n = 0; n < 5000; ++n) {
      const Vec3 p = (radius + random.Uniform(-h, h)) * random.Direction();
      const FieldSample sample = grid.Sample(p);
      worst = std::max(worst, std::abs(sample.distance - (p.norm() - radius)));
      EXPECT_LT((sample.gradient - p.normalized()).norm(), 1.5 * h / radius);
    }
    // A chord's sagitta in three directions, h^2/8 (1/r + 1/r), and the mesh's own facets.
    EXPECT_LT(worst, h * h / (4.0 * (radius - h)) + 1e-7);
    EXPECT_LT(worst, 0.4 * last);
    last = worst;
  }
}

TEST(SolidGrid, PaintsWhatLiesWithinARegionsMesh) {
  Body body;
  body.name = "box";
  body.mesh = MakeBox(Vec3(4e-3, 2e-3, 2e-3));
  body.materials.resize(3);
  body.grid.emplace().spacing = 100e-6;
  // A bent pipe that leaves the box, and inside it a box that paints over the pipe.
  const TriangleMesh pipe = MakeBentPipe(0.4e-3, 0.3e-3, 3e-3, 0.5);
  const MaterialRegion box{Vec3(-1e-3, 0.4e-3, -1e-3), Vec3(1e-3, 1e-3, 1e-3), 0.0, 2, {}};
  body.grid->regions = {{Vec3::Zero(), Vec3::Zero(), 0.0, 1, pipe}, box};
  const MeshQuery query(pipe);
  const auto grid = MakeSolidGrid(body);
  int of_pipe = 0;
  EachPoint(grid->field(), [&](const Vec3& p, double distance) {
    if (distance >= 0.0 || query.Nearest(p).distance < 1e-9) return;
    const bool within = query.WindingNumber(p) > 0.5;
    of_pipe += within;
    ASSERT_EQ(grid->Material(p), box.Holds(p) ? 2 : within ? 1 : 0) << p.transpose();
  });
  EXPECT_GT(of_pipe, 100);
  body.grid->regions[0].mesh.triangles.pop_back();
  EXPECT_THAT(ComplaintOf([&] { MakeSolidGrid(body); }),
              HasSubstr("box: region 0: the mesh is open at 3 edges"));
}

TEST(SolidGrid, AgreesWithTheMeshOfABentPipe) {
  const TriangleMesh mesh = MakeBentPipe(0.4e-3, 0.3e-3, 3e-3, 0.5);
  const MeshQuery query(mesh);
  const SolidGrid grid(mesh, {.spacing = 100e-6}, "pipe");
  const double band = grid.field().band();
  EachPoint(grid.field(), [&](const Vec3& p, double distance) {
    const double away = query.Nearest(p).distance;
    ASSERT_NEAR(std::abs(distance), std::min(away, band), 2e-11);
    if (away > 1e-9) {
      ASSERT_EQ(distance<0.0, query.WindingNumber(p)> 0.5) << p.transpose();
    }
  });
}

TEST(SolidGrid, GivesTheSameBitsAgain) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(1e-3, 0.8e-3, 0.6e-3), 5120);
  const SolidGrid one(mesh, {}, "a"), two(mesh, {}, "b");
  const auto& blocks = one.field().lattice().blocks;
  for (int k = 0; k < 8 * blocks[2]; ++k) {
    for (int j = 0; j < 8 * blocks[1]; ++j) {
      for (int i = 0; i < 8 * blocks[0]; ++i) {
        ASSERT_EQ(one.field().At(i, j, k), two.field().At(i, j, k));
      }
    }
  }
}

TEST(SolidGrid, OutsideOfItIsFreeAndSoIsWhatIsNoPlace) {
  const SolidGrid grid(MakeSphere(1e-3, 1280), {.spacing = 100e-6}, "sphere");
  for (const Vec3& p :
       {Vec3(1.0, 0, 0), Vec3(0, -1e300, 0), Vec3(0, 0, std::nan("")), Vec3(INFINITY, 0, 0)}) {
    EXPECT_EQ(grid.Sample(p).distance, grid.field().band());
    EXPECT_EQ(grid.Material(p), 0);
  }
}

TEST(SolidGrid, KnowsTheMaterialOfEachPoint) {
  const auto shell = [](const Vec3& p) { return std::uint8_t(p.norm() > 0.7e-3 ? 1 : 2); };
  const SolidGrid grid(MakeSphere(1e-3, 1280), {.spacing = 50e-6, .material = shell}, "tooth");
  Random random(10);
  for (int n = 0; n < 5000; ++n) {
    const Vec3 p = random.Uniform(0.0, 1e-3) * random.Direction();
    if (std::abs(p.norm() - 0.7e-3) > 45e-6) {
      EXPECT_EQ(grid.Material(p), shell(p));
    }
  }
}

// A molar's bounding box of 10 mm, half filled by an ellipsoid.
TEST(SolidGrid, ToothOfTenMillimetresFitsAtFiftyMicrometres) {
  const SolidGrid grid(MakeEllipsoid(Vec3(5e-3, 5e-3, 5e-3), 20480), {.spacing = 50e-6}, "tooth");
  EXPECT_LT(grid.bytes(), 32u << 20);
}

TEST(SolidGrid, BadMeshesAreRefusedWithARemedy) {
  const TriangleMesh sphere = MakeSphere(1e-3, 320);
  const auto complaint = [&](const TriangleMesh& mesh, const SolidGridOptions& options) {
    return ComplaintOf([&] { SolidGrid(mesh, options, "tooth"); });
  };
  TriangleMesh open = sphere;
  open.triangles.pop_back();
  EXPECT_THAT(complaint(open, {}),
              AllOf(HasSubstr("tooth: the mesh is open at 3 edges"), HasSubstr("close its holes")));
  TriangleMesh turned = sphere;
  for (auto& [a, b, c] : turned.triangles) std::swap(b, c);
  EXPECT_THAT(complaint(turned, {}), HasSubstr("flip its triangles"));
  TriangleMesh wild = sphere;
  wild.vertices[0].x() = std::nan("");
  EXPECT_THAT(complaint(wild, {}), HasSubstr("encloses no volume"));
  EXPECT_THAT(complaint({}, {}), HasSubstr("no triangle"));
  EXPECT_THAT(complaint(sphere, {.spacing = 10e-6}), HasSubstr("give 25 to 200 um"));
  EXPECT_THAT(complaint(sphere, {.material = [](const Vec3&) { return std::uint8_t(8); }}),
              HasSubstr("material 8 is not allowed"));
}

TEST(SolidGrid, GridThatWouldNotFitIsRefusedBeforeItTakesItsMemory) {
  // Kilometres: the table alone would take some 10^22 bytes.
  EXPECT_THAT(ComplaintOf([] { SolidGrid(MakeBox(Vec3::Constant(1e3)), {}, "hill"); }),
              AllOf(HasSubstr("hill: a grid of 50 um"), HasSubstr("larger spacing")));
  EXPECT_THAT(ComplaintOf([] {
                SolidGrid(MakeSphere(1e-3, 320), {.spacing = 50e-6, .most_bytes = 1000}, "tooth");
              }),
              HasSubstr("MB"));
  EXPECT_THAT(ComplaintOf([] {
                SolidGrid(MakeSphere(1e-3, 320), {.spacing = 50e-6, .most_bytes = 100000}, "tooth");
              }),
              HasSubstr("MB"));
}

}  // namespace
}  // namespace palpate
