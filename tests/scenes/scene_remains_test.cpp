#include "scenes/scene_remains.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Two objects: three leaves over four triangles of which one is shared, and a leaf alone.
Scene TwoObjects() {
  Scene scene;
  scene.objects.resize(2);
  Body& tooth = scene.objects[0];
  tooth.mesh.triangles.resize(4);
  tooth.tree.leaf_radius.resize(3, 0.001);
  tooth.tree.leaf_triangle_begin = {0, 2, 4, 5};
  tooth.tree.leaf_triangle = {0, 1, 1, 2, 3};
  Body& jaw = scene.objects[1];
  jaw.mesh.triangles.resize(1);
  jaw.tree.leaf_radius.resize(1, 0.001);
  jaw.tree.leaf_triangle_begin = {0, 1};
  jaw.tree.leaf_triangle = {0};
  return scene;
}

TEST(SceneRemains, LoseATriangleWithTheLastLeafThatStandsForIt) {
  SceneRemains remains(TwoObjects());
  EXPECT_THAT(remains.Remove(0, 0), ElementsAre(0u));
  EXPECT_TRUE(remains.leaf_gone(0, 0));
  EXPECT_TRUE(remains.triangle_gone(0, 0));
  EXPECT_FALSE(remains.triangle_gone(0, 1));
  EXPECT_THAT(remains.Remove(0, 1), ElementsAre(1u, 2u));
  EXPECT_TRUE(remains.triangle_gone(0, 1));
  EXPECT_FALSE(remains.triangle_gone(0, 3));
  EXPECT_FALSE(remains.leaf_gone(1, 0));
  EXPECT_FALSE(remains.triangle_gone(1, 0));
}

TEST(SceneRemains, LoseALeafOnce) {
  SceneRemains remains(TwoObjects());
  EXPECT_THAT(remains.Remove(1, 0), ElementsAre(0u));
  EXPECT_THAT(remains.Remove(1, 0), IsEmpty());
}

TEST(SceneRemains, AreUnmovedByEventsOfAnotherScene) {
  SceneRemains remains(TwoObjects());
  EXPECT_THAT(remains.Remove(2, 0), IsEmpty());
  EXPECT_THAT(remains.Remove(0, 3), IsEmpty());
  EXPECT_FALSE(remains.leaf_gone(2, 0));
  EXPECT_FALSE(remains.triangle_gone(0, 4));
}

TEST(SceneRemains, KeepLeavesWithoutTrianglesApart) {
  Scene scene = TwoObjects();
  scene.objects[1].tree.leaf_triangle_begin.clear();
  scene.objects[1].tree.leaf_triangle.clear();
  SceneRemains remains(scene);
  EXPECT_FALSE(remains.triangle_gone(1, 0));
  EXPECT_THAT(remains.Remove(1, 0), IsEmpty());
  EXPECT_TRUE(remains.leaf_gone(1, 0));
}

}  // namespace
}  // namespace palpate
