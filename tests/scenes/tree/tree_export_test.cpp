#include "scenes/tree/tree_export.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <tuple>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/files/scene_bundle.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_error.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::FreshFolder;
using testing::HasSubstr;

Body MakeBody(std::size_t leaves) {
  Body body;
  body.name = "egg";
  body.mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 320);
  body.tree = BuildSphereTree(body.mesh, leaves);
  return body;
}

/// Writes the tree and reads it back with another program's library.
struct ReadBack {
  ReadBack(const Body& body, const TreeExportOptions& options, const std::string& file)
      : scene(nullptr) {
    WriteFileAtomically(file, ExportTree(body, options, file));
    scene = importer.ReadFile(file, aiProcess_ValidateDataStructure);
  }
  Assimp::Importer importer;
  const aiScene* scene;
};

Vec3 VecOf(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

TEST(TreeExport, WritesAPlyOfABallForEachLeaf) {
  const Body body = MakeBody(70);
  const std::vector<Sphere> balls = BallsByLevel(body.tree).back();
  const std::string file = FreshFolder() + "/egg.ply";
  const ReadBack read(body, {}, file);
  ASSERT_NE(read.scene, nullptr) << read.importer.GetErrorString();
  ASSERT_EQ(read.scene->mNumMeshes, 1u);
  const aiMesh& mesh = *read.scene->mMeshes[0];
  ASSERT_EQ(mesh.mNumFaces, 70u * 80u);
  ASSERT_NE(mesh.mColors[0], nullptr);
  std::set<std::tuple<float, float, float>> colours;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const Sphere& ball = balls[f / 80];
    for (int k = 0; k < 3; ++k) {
      const unsigned v = mesh.mFaces[f].mIndices[k];
      const Vec3 p = 1e-3 * VecOf(mesh.mVertices[v]);  // millimetres
      EXPECT_NEAR((p - ball.centre).norm(), ball.radius, 1e-8);
      const aiColor4D& c = mesh.mColors[0][v];
      colours.insert({c.r, c.g, c.b});
    }
  }
  EXPECT_GT(colours.size(), 50u);
  // Our own importer reads it too: closed pieces, wound outwards.
  const MeshReport report = InspectMesh(ImportMesh(file));
  EXPECT_EQ(report.triangles, 70u * 80u);
  EXPECT_TRUE(report.closed());
  EXPECT_GT(report.volume, 0.0);
}

TEST(TreeExport, WritesAGlbInMetresWithANodeForEachBall) {
  const Body body = MakeBody(70);
  const std::vector<Sphere> balls = BallsByLevel(body.tree)[1];
  const std::string file = FreshFolder() + "/egg.glb";
  const ReadBack read(body, {.level = 2}, file);
  ASSERT_NE(read.scene, nullptr) << read.importer.GetErrorString();
  const aiNode& root = *read.scene->mRootNode;
  EXPECT_STREQ(root.mName.C_Str(), "egg");
  ASSERT_EQ(root.mNumChildren, balls.size());
  EXPECT_EQ(read.scene->mNumMeshes, std::min<std::size_t>(16, balls.size()));
  std::set<std::tuple<float, float, float>> colours;
  for (unsigned m = 0; m < read.scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *read.scene->mMeshes[m];
    EXPECT_EQ(mesh.mNumFaces, 320u);
    ASSERT_TRUE(mesh.HasNormals());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      EXPECT_NEAR(VecOf(mesh.mVertices[v]).norm(), 1.0, 1e-6);
      EXPECT_NEAR((VecOf(mesh.mVertices[v]) - VecOf(mesh.mNormals[v])).norm(), 0.0, 1e-6);
    }
    aiColor4D c;
    ASSERT_EQ(read.scene->mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, c),
              AI_SUCCESS);
    colours.insert({c.r, c.g, c.b});
  }
  EXPECT_EQ(colours.size(), read.scene->mNumMeshes);
  for (unsigned i = 0; i < root.mNumChildren; ++i) {
    aiVector3D scale, place;
    aiQuaternion turn;
    root.mChildren[i]->mTransformation.Decompose(scale, turn, place);
    EXPECT_NEAR((VecOf(place) - balls[i].centre).norm(), 0.0, 1e-8);
    EXPECT_NEAR((VecOf(scale) - Vec3::Constant(balls[i].radius)).norm(), 0.0, 1e-8);
    ASSERT_EQ(root.mChildren[i]->mNumMeshes, 1u);
  }
  // A tree of one ball, with a name that JSON must escape.
  Body one = MakeBody(1);
  one.name = "a \"b\\\n\xff";
  EXPECT_NE(ReadBack(one, {}, file).scene, nullptr);
}

TEST(TreeExport, WritesASphThatHoldsTheTree) {
  const Body body = MakeBody(100);
  const auto text = [&](const TreeExportOptions& options) {
    const std::vector<std::uint8_t> bytes = ExportTree(body, options, "egg.sph");
    return std::string(bytes.begin(), bytes.end());
  };
  EXPECT_EQ(text({}), ToSph(SphOf(body.tree), 1e-3));
  const SphTree inch = ParseSph(text({.level = {}, .unit = "inch"}), "egg.sph", 0.0254);
  EXPECT_EQ(BallsOfLevel(inch, inch.levels).size(), 100u);
  EXPECT_EQ(ParseSph(text({.level = 2}), "egg.sph", 1e-3).levels, 3);
}

TEST(TreeExport, SaysWhatItCannotWrite) {
  const Body body = MakeBody(100);
  const auto complaint = [&](const TreeExportOptions& options, const std::string& file) {
    return ComplaintOf([&] { ExportTree(body, options, file); });
  };
  EXPECT_THAT(complaint({}, "egg.obj"), HasSubstr("egg.obj: the extension must be .sph"));
  EXPECT_THAT(complaint({.level = 4}, "egg.ply"), HasSubstr("has levels 1 to 3"));
  EXPECT_THAT(complaint({.level = 0}, "egg.ply"), HasSubstr("has levels 1 to 3"));
  EXPECT_THAT(complaint({.level = {}, .unit = "mm"}, "egg.glb"), HasSubstr("always in metres"));
}

}  // namespace
}  // namespace palpate
