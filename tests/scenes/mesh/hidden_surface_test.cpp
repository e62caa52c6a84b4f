#include "scenes/mesh/hidden_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Adds a box to the mesh; returns it as a named part.
MeshGroup AddBox(const std::string& name, const Vec3& size, const Vec3& at, TriangleMesh& mesh) {
  const auto begin = static_cast<std::uint32_t>(mesh.triangles.size());
  mesh = test::Both(mesh, test::Moved(MakeBox(size), at));
  return {name, begin, static_cast<std::uint32_t>(mesh.triangles.size())};
}

TEST(HiddenSurface, BoxInsideABoxIsHiddenAndTheOuterOneIsNot) {
  TriangleMesh mesh;
  const std::vector<MeshGroup> groups{
      AddBox("outer", Vec3(2, 2, 2), Vec3::Zero(), mesh),
      AddBox("inner", Vec3(1, 1, 1), Vec3(0.2, 0, 0), mesh),
  };
  const HiddenSurface surface(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_EQ(surface.NearestTo(t, Vec3(0.1, 0.3, -0.2)), t >= groups[1].begin) << t;
  }
  const HiddenParts hidden = FindHiddenParts(mesh, groups);
  EXPECT_NEAR(hidden.share, 6.0 / 30.0, 1e-12);  // areas 6 of 24 + 6
  EXPECT_THAT(hidden.of, ElementsAre("inner"));
  EXPECT_THAT(HiddenRemark(hidden, 1.0, "mm"),
              HasSubstr("parts overlap: 20 % of the surface lies inside other parts, as at ("));
  EXPECT_THAT(HiddenRemark(hidden, 1.0, "mm"), HasSubstr(" mm, of \"inner\"; nothing can touch"));
}

TEST(HiddenSurface, WhatStandsApartOrSideBySideHidesNothing) {
  TriangleMesh mesh;
  AddBox("left", Vec3(1, 1, 1), Vec3(-1, 0, 0), mesh);
  AddBox("right", Vec3(1, 1, 1), Vec3(1, 0, 0), mesh);
  EXPECT_EQ(FindHiddenParts(mesh).share, 0.0);
  EXPECT_EQ(HiddenRemark(FindHiddenParts(mesh), 1.0, "mm"), "");
}

TEST(HiddenSurface, CavityIsNotHidden) {
  TriangleMesh mesh;
  AddBox("shell", Vec3(2, 2, 2), Vec3::Zero(), mesh);
  const MeshGroup cavity = AddBox("cavity", Vec3(1, 1, 1), Vec3::Zero(), mesh);
  for (auto t = cavity.begin; t < cavity.end; ++t) test::TurnTriangle(mesh, t);
  EXPECT_EQ(FindHiddenParts(mesh).share, 0.0);
}

TEST(HiddenSurface, FacesThatTwoPartsShareOutsideStayExposed) {
  TriangleMesh mesh;
  AddBox("crown", Vec3(2, 2, 2), Vec3::Zero(), mesh);
  // Its top lies in the crown's top, everything else inside.
  const MeshGroup inlay = AddBox("inlay", Vec3(1, 1, 1), Vec3(0, 0.5, 0), mesh);
  const HiddenSurface surface(mesh);
  int exposed = 0;
  for (std::uint32_t t = inlay.begin; t < inlay.end; ++t) {
    exposed += !surface.NearestTo(t, Vec3(0.1, 0.6, 0.2));
  }
  EXPECT_EQ(exposed, 2);
}

}  // namespace
}  // namespace palpate
