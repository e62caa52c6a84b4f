#include "tests/house/include_rules.h"

#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/house/source_tree.h"
#include "tests/support/read_file.h"

namespace palpate::house {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> Check(const std::string& path, const std::string& text) {
  return IncludeViolations(path, text, [](const std::string& f) {
    return std::filesystem::exists(PALPATE_SOURCE_DIR "/" + f);
  });
}

/// A line in a file, and the complaint about it; empty: it is allowed.
struct Case {
  const char *path, *line, *complaint = nullptr;
};

void ExpectJudged(const std::vector<Case>& cases) {
  for (const auto& [path, line, complaint] : cases) {
    SCOPED_TRACE(std::string(path) + ": " + line);
    const std::vector<std::string> found = Check(path, std::string("\n") + line + "\n");
    if (complaint == nullptr) {
      EXPECT_THAT(found, IsEmpty());
    } else {
      EXPECT_THAT(found, ElementsAre(HasSubstr(complaint)));
    }
  }
}

TEST(IncludeRules, KeepEachFolderToWhatItsRuleNamesAndSayFileAndLine) {
  const char* const step = "server/physics/haptic_step.cpp";
  ExpectJudged({
      {step, "#include \"scenes/files/scene_file.h\"",
       "server/physics/haptic_step.cpp:2: scenes/files/scene_file.h: "},
      {"server/physics/haptic_step.h", "#include \"server/session/servo_loop.h\"", "servo_loop.h"},
      {"server/physics/limits.h", "#include \"server/physics/step_types.h\"", "stands above"},
      {"scenes/tree/sphere.h", "#include \"scenes/catalogue.h\"", "stands above"},
      {step, "#include \"common/dds/endpoint.h\"", "but not common/dds"},
      {step, "#include <spdlog/spdlog.h>", "may use of the libraries: Eigen"},
      {step, "  #  include <dds/dds.h>", "dds/dds.h"},
      // Sessions use physics and scenes, but nothing that loads a scene.
      {"server/session/a.cpp", "#include \"server/physics/haptic_step.h\""},
      {"server/session/a.cpp", "#include \"scenes/scene.h\""},
      {"server/session/a.cpp", "#include \"scenes/catalogue.h\"", "scenes/catalogue.h"},
      {"idl/session.idl", "#include \"idl/haptics.idl\"", "of the project: nothing"},
      {"idl/other.fbs", "include \"idl/scene.fbs\";", "of the project: nothing"},
      {"common/dds/a.cpp", "#include <dds/dds.h>"},
      {"common/dds/a.cpp", "#include \"idl/haptics.h\""},
      {"common/math/a.cpp", "#include <dds/dds.h>", "dds/dds.h"},
      {"scenes/importer/3ds_reader.cpp", "#include <assimp/scene.h>"},
      {"scenes/mesh/mesh_query.cpp", "#include <assimp/scene.h>", "assimp/scene.h"},
      {"devices/openhaptics/a.cpp", "#include <HD/hd.h>"},
      {"devices/simulated/a.cpp", "#include <HD/hd.h>", "HD/hd.h"},
      {"client/station/a.cpp", "#include <HD/hd.h>", "HD/hd.h"},
      {"client/station/a.cpp", "#include \"client/station/display.h\""},
      {"client/station/a.cpp", "#include \"client/load/load_run.h\"", "client/load/load_run.h"},
      {"client/station/a.cpp", "#include \"server/physics/haptic_step.h\"", "haptic_step.h"},
      {"scenes/a.cpp", "#include \"scene.h\"", "spelled from the root"},
      {"tests/scenes/a.cpp", "#include \"../scenes/scene.h\"", "spelled from the root"},
      {"scenes/a.cpp", "#include <nlohmann/json.hpp>"},
      {"scenes/a.h", "#include <nlohmann/json.hpp>", ".cpp files only"},
      {"scenes/a.cpp", "#include <Poco/Optional.h>", "unknown library"},
      {"tests/scenes/a.cpp", "#include <Poco/Optional.h>", "unknown library"},
  });
}

TEST(IncludeRules, AskForTheFloorOfWhatIsNew) {
  ExpectJudged({{"common/loose.h", "", "on no floor"},
                {"server/physics/attic/a.h", "", "on no floor"},
                {"server/physics/rows_of_mine.h", "", "on no floor"},
                {"server/physics/rows/a.h", ""},
                {"common/recording/a.cpp", "#include \"common/dds/endpoint.h\""}});
}

TEST(IncludeCircle, IsFoundWhereItIsAndNamesItsFiles) {
  using Includes = std::map<std::string, std::vector<std::string>>;
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {"d"}}}), IsEmpty());
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"b"}}, {"b", {"c", "d"}}, {"d", {"e"}}, {"e", {"b"}}}),
              ElementsAre("b", "d", "e", "b"));
  EXPECT_THAT(IncludeCircle(Includes{{"a", {"a"}}}), ElementsAre("a", "a"));
}

/// A source and its header are one: the includes of both make circles.  An .inl belongs to the
/// source that includes it.
std::string Stem(const std::string& file) {
  return file.ends_with(".inl") ? file : file.substr(0, file.rfind('.'));
}

// common/revision.h: of whatever a step is made, its bits can change with it.
TEST(PhysicsRevision, HashesAllThatThePhysicsIncludes) {
  const std::string root = PALPATE_SOURCE_DIR;
  const std::string list = RunCommand({"cmake", "-D", "source=" + root, "-D", "list=physics", "-P",
                                       root + "/common/revision.cmake"})
                               .text;
  std::set<std::string> hashed;
  std::istringstream lines(list);
  for (std::string file; std::getline(lines, file);) hashed.insert(file);
  ASSERT_TRUE(hashed.contains("server/physics/haptic_step.cpp")) << list;
  for (std::vector<std::string> next(hashed.begin(), hashed.end()); !next.empty();) {
    const std::string file = next.back();
    next.pop_back();
    // Times of stages, how a session's threads meet, and how many threads make bodies decide no
    // bit.
    if (IsBelow(file, "common/realtime") || IsBelow(file, "common/dds") ||
        file == "common/program/machine.h") {
      continue;
    }
    EXPECT_TRUE(hashed.contains(file)) << file << ": let common/revision.cmake hash it";
    if (!IsBelow(file, "server/physics")) continue;
    for (const std::string& included : ProjectIncludes(ReadWholeFile(root + "/" + file))) {
      if (!hashed.contains(included)) next.push_back(included);
    }
  }
}

TEST(IncludeRules, HoldInEverySourceFile) {
  const std::string root = PALPATE_SOURCE_DIR;
  const std::vector<std::string> files = SourceFiles(root);
  const std::set<std::string> known(files.begin(), files.end());
  int checked = 0;
  std::map<std::string, std::vector<std::string>> includes, of_rooms;
  for (const std::string& file : files) {
    if (!file.ends_with(".h") && !file.ends_with(".cpp") && !file.ends_with(".inl") &&
        !file.ends_with(".idl") && !file.ends_with(".fbs")) {
      continue;
    }
    ++checked;
    const std::string text = ReadWholeFile(root + "/" + file);
    includes[file] = ProjectIncludes(text);
    for (const std::string& include : includes[file]) {
      if (include.ends_with(".inl") || Stem(include) == Stem(file)) continue;
      of_rooms[Stem(file)].push_back(Stem(include));
    }
    for (const std::string& violation :
         IncludeViolations(file, text, [&](const std::string& f) { return known.contains(f); })) {
      ADD_FAILURE() << violation;
    }
  }
  EXPECT_THAT(IncludeCircle(includes), IsEmpty());
  EXPECT_THAT(IncludeCircle(of_rooms), IsEmpty());
  EXPECT_GT(checked, 10) << "git lists too few source files below " << root;
}

}  // namespace
}  // namespace palpate::house
