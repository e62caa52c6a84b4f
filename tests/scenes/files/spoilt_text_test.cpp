// Files that people write, spoilt in every way that an editor, a disk or a foe can: each is read,
// or refused by an Error that names the file; nothing else happens.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/pose_script.h"
#include "scenes/files/scene_file.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"
#include "tests/support/random.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using testing::StartsWith;

constexpr int kTries = 400;  // of each scene; of each script, which is a file, a fourth

std::vector<std::string> CatalogueTexts(bool scripts) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(PALPATE_SOURCE_DIR "/scenes/catalogue")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() == ".json" && name.ends_with(".path.json") == scripts) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> texts;
  for (const auto& file : files) texts.push_back(ReadWholeFile(file));
  return texts;
}

/// One to three changes: a byte, a digit, what stands for a value, a piece that is gone, twice
/// there or somewhere else.
std::string Spoilt(std::string text, test::Random& random) {
  static constexpr const char* kValues[] = {
      "-1",      "0",           "1e308",      "1e999",
      "-1e-320", "NaN",         "null",       "true",
      "\"\"",    "\"\\u0000\"", "[]",         "{}",
      "[[[[[[",  "9",           "4294967296", "18446744073709551616",
      "\xff",    "\"../../x\""};
  const auto at = [&] {
    return static_cast<std::size_t>(random.Below(static_cast<int>(text.size())));
  };
  for (int changes = 1 + random.Below(3); changes > 0 && !text.empty(); --changes) {
    const std::size_t i = at();
    const std::size_t n = std::min<std::size_t>(text.size() - i, 1 + at() % 40);
    switch (random.Below(9)) {
      case 0:
        text[i] = static_cast<char>(random.Below(256));
        break;
      case 1:
        text.erase(i, n);
        break;
      case 2:
        text.insert(at(), text.substr(i, n));
        break;
      case 3:
        text.resize(i);
        break;
      case 4:
      case 5:
      case 6: {
        const std::size_t digit = text.find_first_of("0123456789", i);
        if (digit != std::string::npos) text[digit] = static_cast<char>('0' + random.Below(10));
        break;
      }
      default: {  // the next value, where it is a number or a word
        const std::size_t value = text.find_first_of("0123456789-\"tf", i);
        if (value == std::string::npos) break;
        const std::size_t end = text.find_first_of(",]}\n", value);
        const char* other = kValues[random.Below(static_cast<int>(std::size(kValues)))];
        text.replace(value, std::min(end, text.size()) - value, other);
      }
    }
  }
  return text;
}

TEST(SpoiltText, OfASceneIsReadOrRefusedByName) {
  test::Random random(11);
  int read = 0, refused = 0;
  for (const std::string& good : CatalogueTexts(false)) {
    for (int i = 0; i < kTries; ++i) {
      const std::string text = Spoilt(good, random);
      try {
        const SceneDescription scene = ParseScene(text, "folder/demo.json");
        ++read;
        ASSERT_FALSE(scene.tools.empty() || scene.objects.empty()) << text;
        ASSERT_TRUE(std::isfinite(scene.coupling.stiffness) && scene.coupling.stiffness > 0.0)
            << text;
        for (const auto* bodies : {&scene.tools, &scene.objects}) {
          for (const BodyDescription& body : *bodies) {
            ASSERT_TRUE(body.X_WB.p.allFinite()) << text;
            ASSERT_NEAR(body.X_WB.q.norm(), 1.0, 1e-9) << text;
            ASSERT_TRUE(body.leaves >= 1 && body.leaves <= kMaxLeaves) << text;
            ASSERT_TRUE(body.mesh.size.allFinite()) << text;
          }
        }
      } catch (const Error& error) {
        ++refused;
        ASSERT_THAT(error.what(), StartsWith("folder/demo.json")) << text;
      }
    }
  }
  EXPECT_GT(read, 300) << "else nothing but refusals was tried";
  EXPECT_GT(refused, 300);
}

TEST(SpoiltText, OfAScriptIsReadOrRefusedByName) {
  test::Random random(12);
  const std::string file = testing::TempDir() + "spoilt_script.json";
  int read = 0, refused = 0;
  for (const std::string& good : CatalogueTexts(true)) {
    for (int i = 0; i < kTries / 4; ++i) {
      const std::string text = Spoilt(good, random);
      std::ofstream(file, std::ios::binary) << text;
      try {
        const PoseScript script = PoseScript::Load(file);
        ++read;
        ASSERT_TRUE(std::isfinite(script.duration()) && script.duration() >= 0.0) << text;
        for (int k = 0; k <= 20; ++k) {
          const Pose X = script.At(script.duration() * k / 20.0);
          ASSERT_TRUE(X.p.allFinite()) << text;
          ASSERT_NEAR(X.q.norm(), 1.0, 1e-9) << text;
        }
      } catch (const Error& error) {
        ++refused;
        ASSERT_THAT(error.what(), StartsWith(file)) << text;
      }
    }
  }
  std::filesystem::remove(file);
  EXPECT_GT(read, 75) << "else nothing but refusals was tried";
  EXPECT_GT(refused, 75);
}

TEST(SpoiltText, OfASphereTreeIsReadOrRefusedByName) {
  test::Random random(13);
  const std::string good =
      ToSph(SphOf(BuildSphereTree(MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 320), 20), 2), 1e-3);
  int read = 0, refused = 0;
  for (int i = 0; i < 5 * kTries; ++i) {
    const std::string text = Spoilt(good, random);
    try {
      const SphTree tree = ParseSph(text, "folder/demo.sph", 1e-3);
      ++read;
      // Nothing that the text could not hold was made room for.
      ASSERT_LE(tree.nodes.size(), text.size()) << text;
      for (const SphTree::Node& node : tree.nodes) {
        ASSERT_TRUE(node.ball.centre.allFinite() && std::isfinite(node.ball.radius) &&
                    std::isfinite(node.importance))
            << text;
      }
      for (int level = 1; level <= tree.levels; ++level) {
        for (const Sphere& ball : BallsOfLevel(tree, level)) ASSERT_GT(ball.radius, 0.0) << text;
      }
      ASSERT_FALSE(BallsOfLevel(tree, tree.levels).empty()) << text;
    } catch (const Error& error) {
      ++refused;
      ASSERT_THAT(error.what(), StartsWith("folder/demo.sph:")) << text;
    }
  }
  EXPECT_GT(read, 300) << "else nothing but refusals was tried";
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace palpate
