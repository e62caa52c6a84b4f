#include "scenes/shapes/bur_shapes.h"

#include <array>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/grid/bur.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/shapes/shape_kinds.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::AllOf;
using testing::HasSubstr;

BurProfile Named(const std::string& name) {
  const ShapeChoice bur = BurNamed(name);
  return FindShapeKind("bur")->bur(bur.variant, bur.values);
}

struct Head {
  const char* name;
  double diameter, length;  ///< [mm]
};
const Head kHeads[] = {
    {"001/014", 1.4, 1.4}, {"010/008", 0.8, 1.0}, {"010/016", 1.6, 1.6},  {"010/035", 3.5, 2.1},
    {"237/014", 1.4, 2.0}, {"237/023", 2.3, 2.3}, {"233/012", 1.2, 2.5},  {"234/014", 1.4, 4.0},
    {"107/010", 1.0, 3.0}, {"110/012", 1.2, 6.0}, {"139/012", 1.2, 4.0},  {"141/012", 1.2, 8.0},
    {"170/012", 1.2, 3.0}, {"172/016", 1.6, 8.0}, {"173/018", 1.8, 10.0}, {"198/016", 1.6, 8.0},
    {"247/014", 1.4, 5.0}, {"249/012", 1.2, 8.0}, {"250/010", 1.0, 10.0},
};

TEST(BurShapes, NamesHaveTheHeadsThatArePublished) {
  for (const Head& head : kHeads) {
    SCOPED_TRACE(head.name);
    const BurProfile profile = Named(head.name);
    const Bur bur(profile.curve, profile.rounding);
    EXPECT_NEAR(2e3 * bur.radius(), head.diameter, 1e-9);
    EXPECT_NEAR(1e3 * (bur.high() - bur.low()), head.length, 1e-9);
    EXPECT_NEAR(bur.low(), -profile.rounding, 1e-15);
  }
}

// The features of each form: its widest part, and its tip.
TEST(BurShapes, FormsAreWideWhereTheirNamesSay) {
  const auto width_at = [](const std::string& name, double part) {
    const BurProfile profile = Named(name);
    const Bur bur(profile.curve, profile.rounding);
    const double z = bur.low() + part * (bur.high() - bur.low());
    double in = 0.0, out = 1e-2;
    for (int n = 0; n < 60; ++n) {
      const double rho = 0.5 * (in + out);
      Vec3 gradient;
      (bur.Distance(Vec3(rho, 0, z), gradient) < 0.0 ? in : out) = rho;
    }
    return in / bur.radius();
  };
  EXPECT_NEAR(width_at("110/012", 0.1), 1.0, 1e-6);
  EXPECT_NEAR(width_at("110/012", 0.9), 1.0, 1e-6);
  EXPECT_GT(width_at("010/016", 0.1), 0.95);
  EXPECT_LT(width_at("010/016", 0.9), 0.85);
  EXPECT_LT(width_at("172/016", 0.1), 0.75);
  EXPECT_GT(width_at("172/016", 0.95), 0.95);
  EXPECT_GT(width_at("237/014", 0.35), 0.98);
  EXPECT_LT(width_at("237/014", 0.9), 0.6);
  EXPECT_LT(width_at("249/012", 0.05), 0.4);
  EXPECT_GT(width_at("249/012", 0.6), 0.98);
  EXPECT_LT(width_at("249/012", 0.98), 0.9);
  // A pear's end is half a ball, to within its chords.
  const BurProfile pear = Named("237/014");
  const Bur bur(pear.curve, pear.rounding);
  for (double angle = 0.0; angle < 0.5 * M_PI; angle += 0.05) {
    const Vec3 on_ball(0.7e-3 * std::sin(angle), 0, 0.7e-3 - 0.7e-3 * std::cos(angle) + bur.low());
    Vec3 gradient;
    EXPECT_NEAR(bur.Distance(on_ball, gradient), 0.0, 0.02 * 0.7e-3) << angle;
  }
}

TEST(BurShapes, TheToolOfEachNameIsAClosedMeshAboutItsHead) {
  const ShapeKind& kind = *FindShapeKind("bur");
  for (const Head& head : kHeads) {
    SCOPED_TRACE(head.name);
    const ShapeChoice choice = BurNamed(head.name);
    const TriangleMesh mesh = kind.make(choice.variant, choice.values);
    const MeshReport report = InspectMesh(mesh);
    EXPECT_TRUE(report.closed() && report.manifold() && report.oriented());
    const BurProfile profile = Named(head.name);
    const Bur bur(profile.curve, profile.rounding);
    double farthest = 0.0, widest = 0.0;
    for (const Vec3& v : mesh.vertices) {
      if (v.y() > 1e-3 * head.length - 1e-9) continue;  // above its top is the neck
      widest = std::max(widest, std::hypot(v.x(), v.z()));
      Vec3 gradient;
      const Vec3 p(v.x(), -v.z(), v.y() + bur.low());
      farthest = std::max(farthest, std::abs(bur.Distance(p, gradient)));
    }
    EXPECT_NEAR(2e3 * widest, head.diameter, 1e-3);
    EXPECT_LT(farthest, 5e-6);
  }
}

// What lies above the outline cuts nothing, so nothing may come to lie on it.
TEST(BurShapes, NothingBesideTheNeckStandsOutOfTheHead) {
  const BurProfile profiles[] = {BallBur(0.7e-3),
                                 ConeBur(0.3e-3, 0.5e-3, 2e-3, 0.15e-3),
                                 ConeBur(0.6e-3, 0.6e-3, 2e-3, 0.1e-3),
                                 ConeBur(0.5e-3, 0.6e-3, 2e-3, 0.02e-3),
                                 ConeBur(0.5e-3, 0.6e-3, 2e-3, 0.0),
                                 PearBur(0.7e-3, 2e-3),
                                 FlameBur(0.6e-3, 5e-3)};
  for (const BurProfile& profile : profiles) {
    const Bur bur(profile.curve, profile.rounding);
    const TriangleMesh mesh = MakeBur(profile, 60e-3);
    const double top = bur.high() - bur.low();
    double widest = 0.0;
    for (const Vec3& v : mesh.vertices) {
      if (v.y() < top) widest = std::max(widest, std::hypot(v.x(), v.z()));
    }
    for (const auto& triangle : mesh.triangles) {
      Vec3 middle = Vec3::Zero();
      for (const std::uint32_t v : triangle) middle += mesh.vertices[v] / 3.0;
      if (middle.y() > top || std::hypot(middle.x(), middle.z()) < 0.61 * widest) continue;
      Vec3 gradient;
      EXPECT_LT(bur.Distance(Vec3(middle.x(), -middle.z(), middle.y() + bur.low()), gradient), 1e-9)
          << middle.transpose();
    }
  }
}

TEST(BurShapes, ATrephineIsAClosedMeshAboutItsBore) {
  const BurProfile profile = TrephineBur(1.5e-3, 0.4e-3, 6e-3, 0.1e-3);
  const Bur bur(profile.curve, profile.rounding);
  const TriangleMesh mesh = MakeBur(profile, 60e-3);
  const MeshReport report = InspectMesh(mesh);
  EXPECT_TRUE(report.closed() && report.manifold() && report.oriented());
  int in_bore = 0;
  for (const Vec3& v : mesh.vertices) {
    const double rho = std::hypot(v.x(), v.z());
    if (v.y() > 5.6e-3 - 1e-9) continue;  // the bore's roof is as thick as the wall
    Vec3 gradient;
    EXPECT_LT(std::abs(bur.Distance(Vec3(v.x(), -v.z(), v.y() + bur.low()), gradient)), 5e-6);
    in_bore += rho < 1.2e-3;
  }
  EXPECT_GT(in_bore, 100);
}

TEST(BurShapes, WhatIsNotKnownIsToldWhatIs) {
  const std::string complaint = ComplaintOf([] { BurNamed("999/014"); });
  EXPECT_THAT(complaint, AllOf(HasSubstr("'999/014' is not a known bur; give SHAPE/SIZE"),
                               HasSubstr("001 (ball)"), HasSubstr("249 (flame)")));
  for (const char* bad : {"", "001", "001/14", "001/0145", "001/0x4", "001/004", "001/051",
                          "01/014", "001-014", "001/-14"}) {
    EXPECT_THAT(ComplaintOf([&] { BurNamed(bad); }), HasSubstr("is not a known bur")) << bad;
  }
  EXPECT_THAT(ComplaintOf([] { BurNamed("173/008"); }), HasSubstr("give a larger size"));
}

}  // namespace
}  // namespace palpate
