#include "client/load/scene_copies.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate {
namespace {

class SceneCopies : public testing::Test {
 protected:
  static Scene Load(const std::string& scene) {
    LoadOptions no_cache;
    no_cache.use_cache = false;
    return LoadScene(scene, no_cache);
  }
  std::string In(const std::string& file) const { return folder_ / file; }

  const test::Folder folder_;
};

TEST_F(SceneCopies, HaveTheSameToolAndObjectsAndEachANameOfItsOwn) {
  WriteSceneWithCopies("cube", 5, In("many.json"));
  const Scene many = Load(In("many.json"));
  const Scene one = Load("cube");
  EXPECT_EQ(many.name, "many");
  ASSERT_EQ(many.tools.size(), 5u);
  for (std::size_t i = 0; i < many.tools.size(); ++i) {
    EXPECT_EQ(many.tools[i].name, "ball_" + std::to_string(i + 1));
    EXPECT_EQ(many.tools[i].X_WB.p, one.tools[0].X_WB.p);
    EXPECT_EQ(many.tools[i].mesh.vertices, one.tools[0].mesh.vertices);
  }
  EXPECT_EQ(many.objects.size(), one.objects.size());
}

TEST_F(SceneCopies, BringTheHandsScriptAlong) {
  WriteSceneWithCopies("cube", 2, In("many.json"));
  const PoseScript script = PoseScript::Load(ScriptFileBeside(In("many.json")));
  const PoseScript original = PoseScript::Load(ScriptFileBeside("cube"));
  EXPECT_EQ(script.duration(), original.duration());
  EXPECT_EQ(script.At(2.0).p, original.At(2.0).p);
}

TEST_F(SceneCopies, FindTheMeshesThatStandBesideTheScene) {
  std::filesystem::create_directory(In("own"));
  std::ofstream(In("own/part.obj")) << "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\n"
                                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::ofstream(In("own/mine.json")) << R"({// a comment
             "tools": [{"name": "t", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1,
                        "start": {"position_mm": [0, 80, 0]}}],
             "objects": [{"name": "part", "mesh": {"file": "part.obj", "unit": "mm"},
                          "leaves": 8}]})";
  WriteSceneWithCopies(In("own/mine.json"), 2, In("many.json"));
  EXPECT_EQ(Load(In("many.json")).objects[0].mesh.triangles.size(), 4u);
}

TEST_F(SceneCopies, AreRefusedWithTheFileThatCannotBeReadOrWritten) {
  EXPECT_THROW(WriteSceneWithCopies("cub", 2, In("many.json")), Error);
  EXPECT_THAT(test::ComplaintOf([&] { WriteSceneWithCopies("cube", 2, In("none/many.json")); }),
              testing::HasSubstr("none/many.json"));
}

}  // namespace
}  // namespace palpate
