#include "scenes/picture.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

struct Png {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::array<int, 3> At(int x, int y) const {
    const std::uint8_t* p = &rgb[3 * (std::size_t(y) * width + x)];
    return {p[0], p[1], p[2]};
  }
};

Png ReadPng(const std::string& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, file.c_str())) << image.message;
  image.format = PNG_FORMAT_RGB;
  Png png{int(image.width), int(image.height), {}};
  png.rgb.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, png.rgb.data(), 0, nullptr));
  return png;
}

Scene TwoBalls() {
  Scene scene;
  Body ball{"ball", MakeSphere(0.01, 1280), {}, {}};
  ball.tree = BuildSphereTree(ball.mesh, 64);
  scene.tools = {ball};
  scene.objects = {ball};  // of the same shape, which is drawn once
  return scene;
}

TEST(Picture, ShowsTheMeshAndEveryLevelSideBySide) {
  const std::string file = test::FreshFolder() + "/p.png";
  DrawScene(TwoBalls(), std::nullopt, file);
  const Png png = ReadPng(file);
  EXPECT_EQ(png.width, 3 * 480);
  EXPECT_EQ(png.height, 480);
  for (int tile = 0; tile < 3; ++tile) {
    // A round body in the middle, background in the corners.
    EXPECT_NE(png.At(480 * tile + 240, 240), png.At(480 * tile + 5, 240));
    EXPECT_EQ(png.At(480 * tile + 5, 5), png.At(480 * tile + 474, 5));
  }
}

TEST(Picture, DrawsABallAsLargeAsItIs) {
  Scene scene = TwoBalls();
  scene.tools[0].tree = SingleSphereTree(scene.tools[0].mesh, {Vec3::Zero(), 0.01});
  scene.objects.clear();
  const std::string file = test::FreshFolder() + "/p.png";
  DrawScene(scene, 1, file);
  const Png png = ReadPng(file);
  ASSERT_EQ(png.width, 2 * 480);
  for (int tile = 0; tile < 2; ++tile) {
    int covered = 0;
    for (int x = 0; x < 480; ++x) covered += png.At(480 * tile + x, 240) != png.At(480 * tile, 240);
    // 0.78 of the tile is 0.85 times the box's diagonal, sqrt(12) radii.
    EXPECT_NEAR(covered, 480 * 0.78 * 2.0 / (0.85 * 3.4641), 4);
  }
}

TEST(Picture, ShowsTheWholeSceneWithItsBodiesInTheirPlaces) {
  Scene scene = TwoBalls();
  scene.tools[0].X_WB.p = Vec3(0, 0.04, 0);
  scene.objects[0].X_WB.p = Vec3(0, -0.04, 0);
  const std::string file = test::FreshFolder() + "/p.png";
  DrawWhole(scene, file);
  const Png png = ReadPng(file);
  ASSERT_EQ(png.width, 480);
  ASSERT_EQ(png.height, 480);
  // The tool above and the object below in different colours, with background between.
  const auto above = png.At(240, 100);
  const auto below = png.At(240, 380);
  EXPECT_NE(above, png.At(5, 100));
  EXPECT_NE(below, png.At(5, 380));
  EXPECT_NE(above, below);
  EXPECT_EQ(png.At(240, 240), png.At(5, 240));
}

TEST(Picture, RefusesALevelThatDoesNotExistAndAFolderThatIsNotThere) {
  const std::string file = test::FreshFolder() + "/p.png";
  EXPECT_THROW(DrawScene(TwoBalls(), 3, file), UsageError);
  EXPECT_THROW(DrawScene(TwoBalls(), 0, file), UsageError);
  EXPECT_THAT(test::ComplaintOf([] { DrawScene(TwoBalls(), 1, "/nowhere/p.png"); }),
              testing::HasSubstr("/nowhere/p.png: cannot be written"));
}

}  // namespace
}  // namespace palpate
