#include "scenes/tree/sph_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// As the toolkit writes it: with an unused slot, a child without children, and trailing text.
constexpr char kToolkitText[] =
    "3 2\n"
    "0.000000 0.000000 0.000000 10.000000 1.000000\n"
    "-5.000000 0.000000 0.000000 6.000000 0.500000\n"
    "5.000000 0.250000 0.000000 6.000000 1.000000\n"
    "-7.000000 0.000000 0.000000 4.000000 1.000000\n"
    "0.000000 0.000000 0.000000 -0.012500 1.000000\n"
    "0.000000 0.000000 0.000000 -0.012500 1.000000\n"
    "0.000000 0.000000 0.000000 0.000000 1.000000\n"
    "\n\nOptions : \n    depth : 2\n    0.5 0.5\n";

std::string ComplaintAbout(const std::string& text) {
  return ComplaintOf([&] { ParseSph(text, "tree.sph", 1e-3); });
}

TEST(SphFile, ReadsWhatTheToolkitWrites) {
  const SphTree tree = ParseSph(kToolkitText, "tree.sph", 1e-3);
  EXPECT_EQ(tree.levels, 3);
  EXPECT_EQ(tree.degree, 2);
  ASSERT_EQ(tree.nodes.size(), 7u);
  EXPECT_DOUBLE_EQ(tree.nodes[0].ball.radius, 0.01);
  EXPECT_DOUBLE_EQ(tree.nodes[2].ball.centre.y(), 0.25e-3);
  EXPECT_EQ(tree.nodes[1].importance, 0.5);
  for (const int i : {0, 1, 2, 3}) EXPECT_TRUE(tree.nodes[i].used());
  for (const int i : {4, 5, 6}) EXPECT_FALSE(tree.nodes[i].used());
}

TEST(SphFile, TakesLinesWithoutImportanceWithASecondBallAndOfWindows) {
  const SphTree tree = ParseSph(
      "2 2\r\n\r\n0 0 0 3\r\n1 0 0 2 0.5 9 9 9 9 -1\r\n\t-1e0  0 0 2 1\r\n", "tree.sph", 1.0);
  ASSERT_EQ(tree.nodes.size(), 3u);
  EXPECT_EQ(tree.nodes[0].importance, 1.0);
  EXPECT_EQ(tree.nodes[1].importance, 0.5);
  EXPECT_EQ(tree.nodes[2].ball.centre, Vec3(-1, 0, 0));
  // One level is a root, however many nodes follow.
  EXPECT_EQ(ParseSph("1 8\n0 0 0 3 1\n0 0 0 2 1\n", "tree.sph", 1.0).nodes.size(), 1u);
}

TEST(SphFile, KeepsWhatHasNoChildrenAtFinerLevels) {
  const SphTree tree = ParseSph(kToolkitText, "tree.sph", 1e-3);
  ASSERT_EQ(BallsOfLevel(tree, 1).size(), 1u);
  ASSERT_EQ(BallsOfLevel(tree, 2).size(), 2u);
  const std::vector<Sphere> finest = BallsOfLevel(tree, 3);
  ASSERT_EQ(finest.size(), 2u);  // the second of level 2 has no children
  EXPECT_DOUBLE_EQ(finest[0].centre.x(), 5e-3);
  EXPECT_DOUBLE_EQ(finest[1].centre.x(), -7e-3);
}

TEST(SphFile, SaysInWhichLineItIsDamaged) {
  const std::string text = kToolkitText;
  EXPECT_THAT(ComplaintAbout(""), StartsWith("tree.sph:1: does not begin with"));
  EXPECT_THAT(ComplaintAbout("ply\nformat ascii 1.0\n"), StartsWith("tree.sph:1: does not begin"));
  EXPECT_THAT(ComplaintAbout("3 2 1\n"), HasSubstr("does not begin with"));
  EXPECT_THAT(ComplaintAbout("0 8\n0 0 0 1 1\n"), HasSubstr("0 levels are not possible"));
  EXPECT_THAT(ComplaintAbout("2 0\n0 0 0 1 1\n"), HasSubstr("a degree of 0 is not possible"));
  EXPECT_THAT(ComplaintAbout("-3 8\n0 0 0 1 1\n"), HasSubstr("-3 levels are not possible"));
  std::string bad = text;
  bad.replace(bad.find("0.250000"), 8, "nan     ");
  EXPECT_THAT(ComplaintAbout(bad), StartsWith("tree.sph:4: is not a node"));
  bad = text;
  bad.replace(bad.find("0.250000"), 8, "1e400   ");
  EXPECT_THAT(ComplaintAbout(bad), StartsWith("tree.sph:4: is not a node"));
  bad = text;
  bad.replace(bad.find("0.500000"), 8, "-inf    ");
  EXPECT_THAT(ComplaintAbout(bad), StartsWith("tree.sph:3: has no finite number"));
  bad = text;
  bad.replace(bad.find("0.250000"), 8, "1e12    ");
  EXPECT_THAT(ComplaintAbout(bad),
              AllOf(StartsWith("tree.sph:4: "), HasSubstr("give the unit of the file")));
  EXPECT_THAT(ComplaintAbout(text.substr(0, text.find("-7.0"))),
              AllOf(StartsWith("tree.sph:4: ends after 3 of the 7 nodes"), HasSubstr("truncated")));
  EXPECT_THAT(ComplaintAbout("1 8\n0 0 0 -1 1\n"), HasSubstr("no node has a radius above 0"));
  EXPECT_THAT(ComplaintOf([] { ReadSph("/nowhere/tree.sph", 1.0); }),
              StartsWith("/nowhere/tree.sph: No such file"));
}

TEST(SphFile, TakesNoMemoryForNodesThatTheFileCannotHold) {
  for (const std::string header :
       {"2 7", "24 2", "7 1000", "3 2147483647", "2 100", "24 2147483647"}) {
    EXPECT_THAT(ComplaintAbout(header + "\n0 0 0 1 1\n"), HasSubstr("more nodes than its"))
        << header;
  }
  const std::string folder = test::FreshFolder();
  const std::string file = folder + "/large.sph";
  std::ofstream(file) << "1 8\n";
  std::filesystem::resize_file(file, kLargestSphFile + 1);
  EXPECT_THAT(ComplaintOf([&] { ReadSph(file, 1.0); }), HasSubstr("holds more than 128 MiB"));
  std::filesystem::remove(file);
}

TEST(SphFile, WritesWhatItReads) {
  const SphTree tree = ParseSph(kToolkitText, "tree.sph", 1e-3);
  const std::string text = ToSph(tree, 1e-3);
  EXPECT_EQ(text, std::string(kToolkitText).substr(0, text.size()));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 8);
}

TEST(SphFile, HoldsATreeOfOurOwnToSixDecimals) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  for (const std::size_t leaves : {1, 8, 9, 100, 600}) {
    const SphereTree tree = BuildSphereTree(mesh, leaves);
    const SphTree made = SphOf(tree);
    EXPECT_EQ(made.levels, tree.levels() + 1);
    EXPECT_EQ(made.degree, 8);
    const SphTree read = ParseSph(ToSph(made, 1e-3), "own.sph", 1e-3);
    ASSERT_EQ(read.nodes.size(), made.nodes.size());
    for (std::size_t i = 0; i < made.nodes.size(); ++i) {
      ASSERT_EQ(read.nodes[i].used(), made.nodes[i].used());
      if (!made.nodes[i].used()) continue;
      EXPECT_LT((read.nodes[i].ball.centre - made.nodes[i].ball.centre).norm(), 1e-9);
      EXPECT_NEAR(read.nodes[i].ball.radius, made.nodes[i].ball.radius, 0.51e-9);
    }
    // The leaves are those of the tree, each once.
    std::vector<Sphere> last = BallsOfLevel(made, made.levels);
    ASSERT_EQ(last.size(), leaves);
    std::vector<double> there, here = tree.leaf_x;
    for (const Sphere& ball : last) there.push_back(ball.centre.x());
    std::sort(there.begin(), there.end());
    std::sort(here.begin(), here.end());
    EXPECT_EQ(there, here);
    EXPECT_EQ(SphOf(tree, 1).levels, 2);
  }
}

TEST(SphFile, PutsEachLeafOfOurTreesBelowBallsThatHoldIt) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  const SphTree tree = SphOf(BuildSphereTree(mesh, 600));
  std::size_t first = 1;
  for (int l = 1; l < tree.levels - 1; ++l) first = first * 8 + 1;
  std::size_t used = 0;
  for (std::size_t i = first; i < tree.nodes.size(); ++i) {
    if (!tree.nodes[i].used()) continue;
    ++used;
    const Sphere& leaf = tree.nodes[i].ball;
    for (std::size_t above = i; above > 0;) {
      above = (above - 1) / 8;
      const Sphere& ball = tree.nodes[above].ball;
      ASSERT_TRUE(tree.nodes[above].used());
      EXPECT_LE((leaf.centre - ball.centre).norm() + leaf.radius, ball.radius * (1.0 + 1e-9));
    }
  }
  EXPECT_EQ(used, 600u);
}

}  // namespace
}  // namespace palpate
