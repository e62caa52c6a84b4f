#include "client/course/exercise.h"

#include <fstream>

#include <gmock/gmock.h>

#include "common/files/project_files.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/refusals.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

const std::string kShipped = PALPATE_SOURCE_DIR "/client/course/exercises";

constexpr const char* kExercise = R"({
  "title": {"en": "A light hand", "de": "Leichte Hand"},
  "scene": "caries",
  "tool": "bur",
  "instruction": {"text": "Open the tooth."},
  "goal": "No more than 2 N",
  "limits": {"force_N": 2, "time_s": 60},
  "trials": 3,
  "criteria": {
    "pass": 60,
    "criteria": [
      {"name": "Decay", "measure": "left_share", "tissue": "caries", "best": 0, "worst": 1}
    ]
  }
})";

class ExerciseTest : public testing::Test {
 protected:
  /// The complaint about the exercise with `what` replaced by `by`.
  std::string Complaint(const std::string& what, const std::string& by) {
    std::string text = kExercise;
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    std::ofstream(file_) << text.replace(at, what.size(), by);
    return ComplaintOf([&] { LoadExercise(file_); });
  }
  const Folder folder_;
  const std::string file_ = folder_ / "light.exercise.json";
};

TEST_F(ExerciseTest, IsReadWithItsTextsByLanguageAndTheScenesScriptAsItsExpert) {
  std::ofstream(file_) << kExercise;
  const Exercise exercise = LoadExercise(file_);
  EXPECT_EQ(exercise.name, "light");
  EXPECT_EQ(exercise.title.at("de"), "Leichte Hand");
  EXPECT_EQ(exercise.instruction.at("en"), "Open the tooth.");
  EXPECT_EQ(exercise.scene_name, "caries");
  EXPECT_THAT(exercise.tools, testing::ElementsAre("bur"));
  EXPECT_EQ(exercise.most_N, 2.0);
  EXPECT_EQ(exercise.most_s, 60.0);
  EXPECT_THAT(exercise.expert, testing::EndsWith("caries.path.json"));
  EXPECT_EQ(exercise.criteria.title, "A light hand");
  EXPECT_EQ(LoadCriteria(file_).criteria.size(), 1u) << "palpate-replay score takes it as it is";
}

TEST_F(ExerciseTest, MayBeDoneWithEachBurOfItsScene) {
  const auto shipped = [](const std::string& name) {
    return LoadExercise(kShipped + "/" + name + kExerciseEnding).tools;
  };
  EXPECT_THAT(shipped("cavity-class-1"), testing::ElementsAre("bur", "pear-010", "round-010"));
  EXPECT_THAT(shipped("light-force"), testing::ElementsAre("probe")) << "which does not cut";
}

TEST_F(ExerciseTest, NamesFileLineAndFieldOfWhatIsWrong) {
  ExpectRefusals("tests/course/exercise.refusals",
                 [&](const auto& inputs) { return Complaint(inputs.at(0), inputs.at(1)); });
}

TEST_F(ExerciseTest, LeavesOutOfAFolderWhatHasAMistakeAndSaysSo) {
  std::ofstream(file_) << kExercise;
  std::ofstream(folder_ / "bad.exercise.json") << "{}";
  std::vector<std::string> refused;
  const auto found =
      LoadExercises(folder_ / "", [&](const std::string& why) { refused.push_back(why); });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].name, "light");
  EXPECT_THAT(refused, testing::ElementsAre(HasSubstr("title is missing")));
  EXPECT_TRUE(LoadExercises(folder_ / "none", {}).empty());
}

TEST(ShippedExercises, AreWholeInThreeLanguagesAndNameTheirSources) {
  const auto all = LoadExercises(kShipped, [](const std::string& why) { ADD_FAILURE() << why; });
  EXPECT_EQ(all.size(), 12u);
  const std::string page = ReadWholeFile(kShipped + "/README.md", JsonNode::kMostBytes);
  const std::string teach =
      ReadWholeFile(PALPATE_SOURCE_DIR "/client/teach.md", JsonNode::kMostBytes);
  const std::size_t serves = teach.find("palpate-server periodontal");
  const std::string served = teach.substr(serves, teach.find("--seats", serves) - serves);
  for (const Exercise& exercise : all) {
    std::vector<const LocalText*> texts{&exercise.title, &exercise.instruction, &exercise.goal};
    for (const Criterion& criterion : exercise.criteria.criteria) {
      texts.push_back(&criterion.names);
      if (!criterion.why.empty()) texts.push_back(&criterion.why);
    }
    for (const ProbingSite& site : exercise.criteria.sites) texts.push_back(&site.names);
    for (const LocalText* text : texts) {
      for (const char* language : {"en", "de", "zh"}) {
        EXPECT_TRUE(text->contains(language)) << exercise.name << ": " << language;
      }
    }
    EXPECT_FALSE(exercise.sources.empty()) << exercise.name;
    EXPECT_THAT(page, HasSubstr("`" + exercise.name + "`"));
    EXPECT_EQ(exercise.scene, exercise.scene_name) << "a copy in a course finds it, too";
    EXPECT_THAT(served, testing::ContainsRegex("[ \n]" + exercise.scene + "[ \n]"))
        << "teach.md's server serves every exercise";
  }
}

}  // namespace
}  // namespace palpate::test
