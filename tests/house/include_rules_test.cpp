#include "tests/house/include_rules.h"

#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace palpate::house {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A small project that has what the includes below name.
std::vector<std::string> Check(const std::string& path, const std::string& text) {
  static const std::set<std::string> kFiles = {"common/math/pose.h",
                                               "common/dds/endpoint.h",
                                               "common/files/whole_file.h",
                                               "common/recording/recorded_type.h",
                                               "client/load/load.h",
                                               "client/station/table.h",
                                               "idl/haptics.idl",
                                               "idl/scene.fbs",
                                               "scenes/catalogue.h",
                                               "scenes/files/scene_file.h",
                                               "scenes/mesh/mesh_query.h",
                                               "scenes/scene.h",
                                               "scenes/shapes/shapes.h",
                                               "scenes/sphere_tree.h",
                                               "scenes/tree/sphere.h",
                                               "server/physics/haptic_model.h",
                                               "server/physics/haptic_step.h",
                                               "server/physics/limits.h",
                                               "server/physics/rows/contact_rows.h",
                                               "server/physics/simd/kernels.h",
                                               "server/physics/solve/response.h",
                                               "server/physics/start_pose.h",
                                               "server/physics/step_types.h",
                                               "server/physics/surface/contact_bodies.h",
                                               "server/physics/tree/leaf_wear.h",
                                               "server/session/servo_loop.h"};
  return IncludeViolations(path, text, [](const std::string& f) { return kFiles.contains(f); });
}

TEST(IncludeRules, KeepPhysicsFromTheRestAndNameFileAndLine) {
  EXPECT_THAT(
      Check("server/physics/haptic_step.cpp", "\n#include \"scenes/files/scene_file.h\"\n"),
      ElementsAre(HasSubstr("server/physics/haptic_step.cpp:2: scenes/files/scene_file.h: ")));
  EXPECT_THAT(Check("server/physics/haptic_step.h", "#include \"server/session/servo_loop.h\"\n"),
              ElementsAre(HasSubstr("servo_loop.h")));
  EXPECT_THAT(Check("server/physics/haptic_step.h", "#include \"common/dds/endpoint.h\"\n"),
              ElementsAre(HasSubstr("but not common/dds")));
  EXPECT_THAT(Check("server/physics/haptic_step.cpp", "#include <spdlog/spdlog.h>\n"),
              ElementsAre(HasSubstr("may use of the libraries: Eigen")));
  EXPECT_THAT(Check("server/physics/haptic_step.cpp", "  #  include <dds/dds.h>\n"),
              ElementsAre(HasSubstr("dds/dds.h")));
}

const std::vector<std::string> kFromTheBottomUp = {"limits.h",
                                                   "simd/kernels.h",
                                                   "step_types.h",
                                                   "tree/leaf_wear.h",
                                                   "surface/contact_bodies.h",
                                                   "haptic_model.h",
                                                   "rows/contact_rows.h",
                                                   "solve/response.h",
                                                   "haptic_step.h",
                                                   "start_pose.h"};

TEST(IncludeRules, LetEachFloorOfPhysicsLookDownAndNoneUp) {
  const std::string folder = "server/physics/";
  for (std::size_t from = 0; from < kFromTheBottomUp.size(); ++from) {
    for (std::size_t to = 0; to < kFromTheBottomUp.size(); ++to) {
      const std::string path = folder + kFromTheBottomUp[from];
      const std::string include = folder + kFromTheBottomUp[to];
      const auto violations = Check(path, "#include \"" + include + "\"\n");
      if (to <= from) {
        EXPECT_THAT(violations, IsEmpty());
      } else {
        EXPECT_THAT(violations, ElementsAre(HasSubstr(path + ":1: " + include + ": stands above")));
      }
    }
  }
}

TEST(IncludeRules, LetScenesLookDownFromCompilerToMesh) {
  const std::vector<std::string> from_below = {
      "scenes/scene.h",       "scenes/mesh/mesh_query.h",  "scenes/shapes/shapes.h",
      "scenes/tree/sphere.h", "scenes/files/scene_file.h", "scenes/catalogue.h"};
  for (std::size_t from = 0; from < from_below.size(); ++from) {
    for (std::size_t to = 0; to < from_below.size(); ++to) {
      EXPECT_EQ(Check(from_below[from], "#include \"" + from_below[to] + "\"\n").empty(),
                to <= from)
          << from_below[from] << " includes " << from_below[to];
    }
  }
}

TEST(IncludeRules, LetCommonLookDownFromRecordingsToMathematics) {
  const std::vector<std::string> from_below = {"common/math/pose.h", "common/files/whole_file.h",
                                               "common/dds/endpoint.h",
                                               "common/recording/recorded_type.h"};
  for (std::size_t from = 0; from < from_below.size(); ++from) {
    for (std::size_t to = from + 1; to < from_below.size(); ++to) {
      EXPECT_THAT(Check(from_below[from], "#include \"" + from_below[to] + "\"\n"), Not(IsEmpty()))
          << from_below[from] << " includes " << from_below[to];
    }
  }
  EXPECT_THAT(Check("common/recording/a.cpp", "#include \"common/dds/endpoint.h\"\n"), IsEmpty());
  EXPECT_THAT(Check("common/loose.h", ""), ElementsAre(HasSubstr("on no floor")));
}

TEST(IncludeRules, AskForTheFloorOfWhatIsNewInPhysics) {
  EXPECT_THAT(Check("server/physics/attic/a.h", ""), ElementsAre(HasSubstr("on no floor")));
  EXPECT_THAT(Check("server/physics/rows_of_mine.h", ""), ElementsAre(HasSubstr("on no floor")));
  EXPECT_THAT(Check("server/physics/rows/a.h", ""), IsEmpty());
}

TEST(IncludeRules, LetSessionsUsePhysicsAndWhatASceneIsButNotHowItLoads) {
  EXPECT_THAT(Check("server/session/a.cpp",
                    "#include \"server/physics/haptic_step.h\"\n#include \"scenes/scene.h\"\n"),
              IsEmpty());
  EXPECT_THAT(Check("server/session/a.cpp", "#include \"scenes/catalogue.h\"\n"),
              ElementsAre(HasSubstr("scenes/catalogue.h")));
}

TEST(IncludeRules, LetTheTypesThatTravelIncludeNothing) {
  EXPECT_THAT(Check("idl/session.idl", "#include \"idl/haptics.idl\"\n"),
              ElementsAre(HasSubstr("of the project: nothing")));
  EXPECT_THAT(Check("idl/other.fbs", "include \"idl/scene.fbs\";\n"),
              ElementsAre(HasSubstr("of the project: nothing")));
}

TEST(IncludeRules, KeepDdsInItsFolder) {
  EXPECT_THAT(Check("common/dds/a.cpp", "#include <dds/dds.h>\n#include \"idl/haptics.h\"\n"),
              IsEmpty());
  EXPECT_THAT(Check("common/math/a.cpp", "#include <dds/dds.h>\n"),
              ElementsAre(HasSubstr("dds/dds.h")));
  EXPECT_THAT(Check("common/math/a.cpp", "#include \"common/dds/endpoint.h\"\n"),
              ElementsAre(HasSubstr("but not common/dds")));
}

TEST(IncludeRules, KeepAssimpToTheReaderOf3ds) {
  EXPECT_THAT(Check("scenes/importer/3ds_reader.cpp", "#include <assimp/scene.h>\n"), IsEmpty());
  EXPECT_THAT(Check("scenes/mesh/mesh_query.cpp", "#include <assimp/scene.h>\n"),
              ElementsAre(HasSubstr("assimp/scene.h")));
}

TEST(IncludeRules, KeepAVendorsAbiInItsFolder) {
  EXPECT_THAT(Check("devices/openhaptics/a.cpp", "#include <HD/hd.h>\n"), IsEmpty());
  EXPECT_THAT(Check("devices/simulated/a.cpp", "#include <HD/hd.h>\n"),
              ElementsAre(HasSubstr("HD/hd.h")));
  EXPECT_THAT(Check("client/station/a.cpp", "#include <HD/hd.h>\n"),
              ElementsAre(HasSubstr("HD/hd.h")));
}

TEST(IncludeRules, KeepClientsFromTheServerAndFromEachOther) {
  EXPECT_THAT(Check("client/station/a.cpp", "#include \"client/station/table.h\"\n"), IsEmpty());
  EXPECT_THAT(Check("client/station/a.cpp", "#include \"client/load/load.h\"\n"),
              ElementsAre(HasSubstr("client/load/load.h")));
  EXPECT_THAT(Check("client/station/a.cpp", "#include \"server/physics/haptic_step.h\"\n"),
              ElementsAre(HasSubstr("haptic_step.h")));
}

TEST(IncludeRules, AskForTheSpellingFromTheRoot) {
  EXPECT_THAT(Check("scenes/a.cpp", "#include \"scene.h\"\n"),
              ElementsAre(HasSubstr("spelled from the root")));
  EXPECT_THAT(Check("tests/scenes/a.cpp", "#include \"../scenes/scene.h\"\n"),
              ElementsAre(HasSubstr("spelled from the root")));
}

TEST(IncludeRules, KeepSlowHeadersOutOfHeadersAndUnknownLibrariesOutOfTheHouse) {
  EXPECT_THAT(Check("scenes/a.cpp", "#include <nlohmann/json.hpp>\n"), IsEmpty());
  EXPECT_THAT(Check("scenes/a.h", "#include <nlohmann/json.hpp>\n"),
              ElementsAre(HasSubstr(".cpp files only")));
  EXPECT_THAT(Check("scenes/a.cpp", "#include <Poco/Optional.h>\n"),
              ElementsAre(HasSubstr("unknown library")));
  EXPECT_THAT(Check("tests/scenes/a.cpp", "#include <Poco/Optional.h>\n"),
              ElementsAre(HasSubstr("unknown library")));
}

TEST(IncludeCircle, IsFoundWhereItIsAndNamesItsFiles) {
  using Includes = std::map<std::string, std::vector<std::string>>;
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {"d"}}}), IsEmpty());
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"b"}}, {"b", {"c", "d"}}, {"d", {"e"}}, {"e", {"b"}}}),
              ElementsAre("b", "d", "e", "b"));
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"a"}}}), ElementsAre("a", "a"));
}

TEST(IncludeRules, HoldInEverySourceFile) {
  const std::string root = PALPATE_SOURCE_DIR;
  const std::vector<std::string> files = SourceFiles(root);
  const std::set<std::string> known(files.begin(), files.end());
  int checked = 0;
  std::map<std::string, std::vector<std::string>> includes;
  for (const std::string& file : files) {
    if (!file.ends_with(".h") && !file.ends_with(".cpp") && !file.ends_with(".inl") &&
        !file.ends_with(".idl") && !file.ends_with(".fbs")) {
      continue;
    }
    ++checked;
    const std::string text = ReadFile(root + "/" + file);
    includes[file] = ProjectIncludes(text);
    for (const std::string& violation :
         IncludeViolations(file, text, [&](const std::string& f) { return known.contains(f); })) {
      ADD_FAILURE() << violation;
    }
  }
  EXPECT_THAT(IncludeCircle(includes), IsEmpty());
  EXPECT_GT(checked, 10) << "git lists too few source files below " << root;
}

}  // namespace
}  // namespace palpate::house
