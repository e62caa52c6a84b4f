#include "scenes/shapes/shape_kinds.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/shapes/dental_shapes.h"
#include "scenes/shapes/mouth_shapes.h"
#include "scenes/shapes/shapes.h"
#include "scenes/shapes/tooth_forms.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

std::vector<double> UsualValues(const ShapeKind& kind) {
  std::vector<double> values;
  for (const ShapeParameter& p : kind.parameters) values.push_back(p.unit * p.usual);
  return values;
}

/// Closed, in one piece, and neither too coarse nor too large.
void ExpectASolidOfModerateSize(const TriangleMesh& mesh) {
  const MeshReport r = InspectMesh(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_TRUE(r.manifold());
  EXPECT_TRUE(r.oriented());
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.degenerate_triangles, 0u);
  EXPECT_EQ(r.duplicate_triangles, 0u);
  EXPECT_GT(r.volume, 0.0);
  EXPECT_GT(r.triangles, 500u);
  EXPECT_LT(r.triangles, 40000u);
}

void ExpectNoPassageThroughItself(const TriangleMesh& mesh) {
  const MeshQuery query(mesh);
  int folded = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); t += 5) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 middle = (mesh.vertices[i] + mesh.vertices[j] + mesh.vertices[k]) / 3.0;
    const Vec3 off = 1e-6 * query.FaceNormal(t);
    folded += query.Inside(middle + off) || !query.Inside(middle - off);
  }
  EXPECT_EQ(folded, 0);
}

// Every shape; about a tooth, for five teeth.  One test per kind, as making them takes longest.
class EveryShape : public testing::TestWithParam<std::size_t> {};

TEST_P(EveryShape, IsASolidOfOnePieceThatDoesNotPassThroughItself) {
  const ShapeKind& kind = ShapeKinds()[GetParam()];
  const bool about_a_tooth =
      kind.name == "gingiva" || kind.name == "calculus" || kind.name == "dentine";
  for (std::size_t v = 0; v < std::max<std::size_t>(kind.variants.size(), 1); ++v) {
    if (about_a_tooth && v > 3 && kind.variants[v] != "36") continue;
    SCOPED_TRACE(kind.variants.empty() ? "" : kind.variants[v]);
    const TriangleMesh mesh = kind.make(v, UsualValues(kind));
    ExpectASolidOfModerateSize(mesh);
    ExpectNoPassageThroughItself(mesh);
  }
}

TEST(Dentine, LiesUnderEnamelThatIsThickestOverTheCuspsAndEndsAtTheNeck) {
  const auto names = ToothKindNames();
  const auto molar = static_cast<ToothKind>(std::ranges::find(names, "36") - names.begin());
  const TriangleMesh tooth = MakeTooth(molar, UsualSize(molar));
  const TriangleMesh dentine = MakeDentine(molar, UsualSize(molar), 2e-3);
  const MeshQuery query(dentine);
  double thickest = 0.0, thinnest = 1.0;
  for (const Vec3& v : tooth.vertices) {
    const double under = query.Nearest(v).distance;
    if (v.y() < 0.0) {  // the root is all dentine
      EXPECT_TRUE(query.Inside(v)) << v.transpose();
    } else if (v.y() > 3e-3) {
      EXPECT_FALSE(query.Inside(v)) << v.transpose();
      thinnest = std::min(thinnest, under);
      thickest = std::max(thickest, under);
    }
  }
  EXPECT_GT(thinnest, 0.8e-3);
  EXPECT_GT(thickest, 2.0e-3);
  EXPECT_LT(thickest, 3.0e-3);
}

INSTANTIATE_TEST_SUITE_P(OfKind, EveryShape, testing::Range<std::size_t>(0, ShapeKinds().size()),
                         [](const auto& kind) {
                           std::string name(ShapeKinds()[kind.param].name);
                           std::erase_if(name, [](unsigned char c) { return !std::isalnum(c); });
                           return name;
                         });

TEST(ShapeKinds, ToothHasTheSizeThatIsAskedFor) {
  for (const ToothKind kind :
       {ToothKind::kIncisor, ToothKind::kCanine, ToothKind::kPremolar, ToothKind::kMolar}) {
    ToothSize size = UsualSize(kind);
    size.width *= 1.1;
    size.root *= 0.9;
    const MeshReport r = InspectMesh(MakeTooth(kind, size));
    EXPECT_NEAR(r.box_max.x() - r.box_min.x(), size.width, 0.1 * size.width);
    EXPECT_NEAR(r.box_max.z() - r.box_min.z(), size.depth, 0.05 * size.depth);
    EXPECT_NEAR(r.box_max.y(), size.crown, 0.1 * size.crown);
    EXPECT_NEAR(-r.box_min.y(), size.root, 0.08 * size.root);
  }
}

/// Height at which a ray from above meets the tooth.
double HeightAt(const MeshQuery& tooth, double x, double z) {
  double y = 0.02;
  while (y > -0.01 && !tooth.Inside(Vec3(x, y, z))) y -= 5e-5;
  return y;
}

TEST(ShapeKinds, MolarHasFourCuspsRoundAFossaAndTwoRoots) {
  const TriangleMesh mesh = MakeTooth(ToothKind::kMolar, UsualSize(ToothKind::kMolar));
  const MeshQuery tooth(mesh);
  const double fossa = HeightAt(tooth, 0, 0);
  for (const double x : {-0.0027, 0.0027}) {
    EXPECT_GT(HeightAt(tooth, x, 0.0026), fossa + 5e-4);
    EXPECT_GT(HeightAt(tooth, x, -0.0026), fossa + 5e-4);
    EXPECT_TRUE(tooth.Inside(Vec3(1.1 * x, -0.009, 0)));  // a root
  }
  EXPECT_FALSE(tooth.Inside(Vec3(0, -0.009, 0)));  // between the roots
}

TEST(ShapeKinds, GumLiesCloseToItsToothButForThePocketAndKnowsItsMargin) {
  const ToothSize size = UsualSize(ToothKind::kMolar);
  const TriangleMesh tooth_mesh = MakeTooth(ToothKind::kMolar, size);
  const GumSize gum_size{0.006, 0.0016, 0.0};
  const TriangleMesh gum_mesh = MakeGingiva(ToothKind::kMolar, size, gum_size);
  const MeshQuery tooth(tooth_mesh);
  const MeshQuery gum(gum_mesh);
  // Outwards from a root's middle: tooth, pocket, gum.
  const auto free_width = [&](double y, double sign) {
    double free = 0.0;
    for (double z = 0.0; z < 0.008; z += 2e-5) {
      const Vec3 p(0.0022, y, sign * z);
      if (!tooth.Inside(p) && !gum.Inside(p)) free += 2e-5;
    }
    return free;
  };
  EXPECT_NEAR(free_width(-0.002, 1.0), 0.0016, 4e-4);
  EXPECT_NEAR(free_width(-0.004, 1.0), 0.0016, 4e-4);
  EXPECT_LT(free_width(-0.0075, 1.0), 2e-4);  // below the pocket
  EXPECT_LT(free_width(-0.004, -1.0), 2e-4);  // on the tooth's other side

  // The gum begins at its margin, around tooth and pocket.
  const std::vector<Vec3> margin = GingivalMargin(ToothKind::kMolar, size, gum_size);
  ASSERT_GE(margin.size(), 48u);
  double area = 0.0;
  for (std::size_t i = 0; i < margin.size(); ++i) {
    const Vec3& p = margin[i];
    const Vec3& next = margin[(i + 1) % margin.size()];
    area += 0.5 * (p.z() * next.x() - p.x() * next.z());  // seen from +y
    EXPECT_LT((next - p).norm(), 1.2e-3) << i;
    EXPECT_LT(gum.Nearest(p).distance, 2e-4) << i;
    const Vec3 outwards = Vec3(p.x(), 0.0, p.z()).normalized();
    EXPECT_TRUE(gum.Inside(p + 5e-4 * outwards - 6e-4 * Vec3::UnitY())) << i;
    EXPECT_FALSE(gum.Inside(p - 4e-4 * outwards - 4e-4 * Vec3::UnitY())) << i;
    EXPECT_FALSE(gum.Inside(p + 3e-4 * Vec3::UnitY())) << i;
  }
  EXPECT_GT(area, 0.0);
  EXPECT_NEAR(tooth.Nearest(margin[0]).distance, gum_size.pocket_width, 3e-4);
  EXPECT_LT(tooth.Nearest(margin[margin.size() / 2]).distance, 3e-4);
  // The same about the neck of a tooth that is true to form.
  const auto names = ToothKindNames();
  const auto molar = ToothKind(std::find(names.begin(), names.end(), "36") - names.begin());
  for (const Vec3& p : GingivalMargin(molar, UsualSize(molar), gum_size)) {
    EXPECT_LT(std::abs(p.y()), 2.5e-3);
    EXPECT_GT(std::hypot(p.x(), p.z()), 3e-3);
    EXPECT_LT(std::hypot(p.x(), p.z()), 9e-3);
  }
}

TEST(ShapeKinds, CalculusLiesOnItsToothAndReachesIntoIt) {
  const ToothSize size = UsualSize(ToothKind::kMolar);
  const TriangleMesh tooth_mesh = MakeTooth(ToothKind::kMolar, size);
  const TriangleMesh crust = MakeCalculus(ToothKind::kMolar, size, 0.004);
  const MeshQuery tooth(tooth_mesh);
  std::size_t inside = 0;
  double highest = 0.0;
  for (const Vec3& v : crust.vertices) {
    inside += tooth.Inside(v);
    if (!tooth.Inside(v)) highest = std::max(highest, tooth.Nearest(v).distance);
  }
  EXPECT_GT(inside, crust.vertices.size() / 5);
  EXPECT_LT(inside, crust.vertices.size() * 4 / 5);
  EXPECT_GT(highest, 3e-4);
  EXPECT_LT(highest, 1.2e-3);
}

TEST(ShapeKinds, ProbeIsThinAtItsTipAndAsLongAsAskedFor) {
  const TriangleMesh mesh = MakeProbe(0.0004, 0.07);
  const MeshReport r = InspectMesh(mesh);
  EXPECT_NEAR(r.box_min.y(), 0.0, 5e-5);
  EXPECT_NEAR(r.box_max.y(), 0.07, 0.003);
  for (const Vec3& v : mesh.vertices) {
    if (v.y() < 0.004) {
      EXPECT_LT(std::hypot(v.x(), v.z()), 0.0006);
    }
  }
}

TEST(ShapeKinds, ScalerHasAHookThatReachesBeyondItsShaft) {
  const TriangleMesh mesh = MakeScaler(0.0003, 0.06);
  double hook = 0.0;
  double shaft = 0.0;
  for (const Vec3& v : mesh.vertices) {
    if (v.y() < 0.0015) hook = std::min(hook, v.z());
    if (v.y() > 0.003) shaft = std::min(shaft, v.z());
  }
  EXPECT_LT(hook, shaft - 0.002);
}

TEST(ShapeKinds, FaceHasAnOpenMouthOfTheSizeAskedForAndAThroatBehindIt) {
  const TriangleMesh mesh = MakeFace(0.06, 0.056);
  const MeshQuery face(mesh);
  // Straight through the lips.
  for (double z = -0.03; z < 0.05; z += 0.001) {
    for (const double s : {-1.0, 1.0}) {
      EXPECT_FALSE(face.Inside(Vec3(s * 0.027, 0, z)));
      EXPECT_FALSE(face.Inside(Vec3(0, s * 0.025, z)));
    }
  }
  const auto closed_at = [&](double x, double y, double back) {
    for (double z = back; z < 0.05; z += 0.001) {
      if (face.Inside(Vec3(x, y, z))) return true;
    }
    return false;
  };
  EXPECT_TRUE(closed_at(0.036, 0, -0.03));
  EXPECT_TRUE(closed_at(0, -0.034, -0.03));
  // From every direction an observer sees a wall.
  for (double x = -0.03; x < 0.031; x += 0.005) {
    for (double y = -0.03; y < 0.031; y += 0.005) EXPECT_TRUE(closed_at(x, y, -0.11));
  }
}

TEST(ShapeKinds, PipeHasTheVolumeThatPappusGivesWhateverItsBend) {
  for (const double bend : {0.0, 0.5 * M_PI, M_PI}) {
    const MeshReport r = InspectMesh(MakeBentPipe(0.033, 0.008, 0.24, bend));
    EXPECT_NEAR(r.volume / (M_PI * (0.041 * 0.041 - 0.033 * 0.033) * 0.24), 1.0, 0.01);
  }
  const MeshReport u = InspectMesh(MakeBentPipe(0.033, 0.008, M_PI * 0.075, M_PI));
  EXPECT_NEAR(u.box_max.x(), 0.15 + 0.041, 1e-3);
  EXPECT_NEAR(u.box_max.z(), 0.075 + 0.041, 1e-3);
}

TEST(ShapeKinds, MouldAndItsToolFillACylinderTogether) {
  const MeshReport mould = InspectMesh(MakeMould(true, 0.03, 0.01, 0.001, 0.008));
  const MeshReport tool = InspectMesh(MakeMould(false, 0.03, 0.01, 0.001, 0.008));
  EXPECT_NEAR((mould.volume + tool.volume) / (M_PI * 0.03 * 0.03 * 0.026), 1.0, 0.005);
  EXPECT_NEAR(mould.box_max.y(), 0.0, 1e-12);
  EXPECT_LT(tool.box_min.y(), -0.0095);
}

std::string SceneWith(const std::string& mesh) {
  return R"({"tools": [{"name": "t", "leaves": 8, "mesh": {"shape": "box", "size_m": [1, 1, 1]}}],
    "objects": [{"name": "o", "leaves": 8, "mesh": )" +
         mesh + "}]}";
}

TEST(ShapeKinds, SceneFilesGiveTheirParametersAndLeaveOutWhatIsUsual) {
  const SceneDescription scene = ParseScene(
      SceneWith(R"({"shape": "gingiva", "kind": "canine", "pocket_depth_mm": 5})"), "f.json");
  const MeshSource& mesh = scene.objects[0].mesh;
  EXPECT_EQ(mesh.kind, MeshSource::Kind::kShape);
  EXPECT_EQ(mesh.what, "gingiva");
  EXPECT_EQ(mesh.variant, 1u);
  ASSERT_EQ(mesh.values.size(), 13u);
  EXPECT_EQ(mesh.values[0], 0.0);
  EXPECT_EQ(mesh.values[4], 0.005);
  EXPECT_EQ(mesh.values[5], 0.0012);
  EXPECT_EQ(mesh.values[7], 0.0) << "of the first of six sites: as deep as the pocket";
  const SceneDescription bent =
      ParseScene(SceneWith(R"({"shape": "pipe", "bend_deg": 180})"), "f.json");
  EXPECT_NEAR(bent.objects[0].mesh.values[3], M_PI, 1e-15);
}

}  // namespace
}  // namespace palpate
