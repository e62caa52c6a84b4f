#include "tests/support/force_shape.h"

#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

/// Forces along x [N]: `newtons` between twelve steps each of the first and the last value.
std::vector<Vec3> Steady(std::initializer_list<double> newtons) {
  std::vector<Vec3> force(12, *newtons.begin() * Vec3::UnitX());
  for (const double f : newtons) force.push_back(f * Vec3::UnitX());
  force.insert(force.end(), 12, force.back());
  return force;
}

TEST(ForceShape, TellsNotchesLedgesAndChangesThatPass) {
  const struct {
    std::initializer_list<double> newtons;
    std::size_t notches, ledges, passing;
  } cases[] = {
      {{5.0, 2.4, 0.0, 1.0, 4.0}, 1, 0, 0},
      {{9.0, 6.0, 4.0, 3.0, 4.0, 6.0, 8.0}, 1, 0, 0},  // no single step halves the force
      {{18.1, 0.0, 0.0, 0.0, 20.1, 0.0, 19.6}, 2, 0, 0},
      {{2.0, 6.0, 6.0, 0.0, 6.0}, 1, 1, 0},  // snaps, and then loses its contacts for a step
      {{5.0, 0.0}, 0, 1, 0},
      {{5.0, 9.0}, 0, 1, 0},
      {{5.0, 2.6, 5.0}, 0, 0, 1},  // not below half
      {{5.0, 12.0, 12.0, 5.0}, 0, 0, 1},
      {{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 1, 0, 0},     // 10 ms
      {{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 0, 2, 0},  // 11 ms
  };
  for (const auto& each : cases) {
    const ForceShape shape = JudgeForce(Steady(each.newtons));
    SCOPED_TRACE(testing::PrintToString(std::vector(each.newtons)));
    EXPECT_EQ(shape.notches.size(), each.notches);
    EXPECT_EQ(shape.ledges.size(), each.ledges);
    EXPECT_EQ(shape.passing.size(), each.passing);
  }
}

TEST(ForceShape, MeasuresANotchFromWhereTheForceJumps) {
  const ForceNotch notch = JudgeForce(Steady({5.0, 2.4, 0.0, 1.0, 4.0})).notches.front();
  EXPECT_EQ(notch.begin, 12u);
  EXPECT_EQ(notch.steps(), 3u);
  EXPECT_EQ(notch.before, 5.0);
  EXPECT_EQ(notch.least, 0.0);
  EXPECT_EQ(notch.after, 4.0);
  const ForceNotch slow = Deepest(JudgeForce(Steady({3.2, 3.1, 3.0, 2.9, 0.0, 3.2})).notches);
  EXPECT_EQ(slow.before, 2.9);
  EXPECT_EQ(slow.steps(), 1u);
}

TEST(ForceShape, LeavesToTheHandWhatTheHandCanHaveDone) {
  // A tap: 5 N away and back, at up to 2 N per millisecond.
  const std::vector<Vec3> tap = Steady({5.0, 3.0, 1.0, 1.0, 3.0, 5.0});
  EXPECT_EQ(JudgeForce(tap).notches.size(), 1u);
  const std::vector<double> by_hand(tap.size(), 2.1);
  EXPECT_TRUE(JudgeForce(tap, by_hand).notches.empty());
  EXPECT_TRUE(JudgeForce(tap, by_hand).ledges.empty());
}

TEST(ForceShape, TakesNoNoiseForAnything) {
  Random random(4);
  std::vector<Vec3> force, small;
  for (int i = 0; i < 5000; ++i) {
    force.push_back(Vec3(3.0, 0.0, 0.0) + random.InCube(0.1));
    small.push_back(random.InCube(0.12));  // often halves and doubles
  }
  for (const std::vector<Vec3>& noise : {force, small}) {
    const ForceShape shape = JudgeForce(noise);
    EXPECT_TRUE(shape.notches.empty());
    EXPECT_TRUE(shape.ledges.empty());
    EXPECT_TRUE(shape.passing.empty());
  }
}

}  // namespace
}  // namespace palpate::test
