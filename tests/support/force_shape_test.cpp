#include "tests/support/force_shape.h"

#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

/// Forces along x [N].
std::vector<Vec3> Along(std::initializer_list<double> newtons) {
  std::vector<Vec3> force;
  for (const double f : newtons) force.push_back(f * Vec3::UnitX());
  return force;
}
/// `newtons` between twelve steps each of the first and the last value.
std::vector<Vec3> Steady(std::initializer_list<double> newtons) {
  std::vector<Vec3> force(12, *newtons.begin() * Vec3::UnitX());
  const std::vector<Vec3> middle = Along(newtons);
  force.insert(force.end(), middle.begin(), middle.end());
  force.insert(force.end(), 12, force.back());
  return force;
}

TEST(ForceShape, SeesANotchAndItsDepthAndLength) {
  const ForceShape shape = JudgeForce(Steady({5.0, 2.4, 0.0, 1.0, 4.0}));
  ASSERT_EQ(shape.notches.size(), 1u);
  const ForceNotch& notch = shape.notches.front();
  EXPECT_EQ(notch.begin, 12u);
  EXPECT_EQ(notch.end, 16u);
  EXPECT_EQ(notch.steps(), 3u);
  EXPECT_EQ(notch.before, 5.0);
  EXPECT_EQ(notch.least, 0.0);
  EXPECT_EQ(notch.after, 4.0);
  EXPECT_EQ(notch.depth(), 5.0);
  EXPECT_TRUE(shape.ledges.empty());
  EXPECT_TRUE(shape.passing.empty());
  EXPECT_EQ(shape.largest_jump.size, 3.0);
  EXPECT_EQ(shape.largest_jump.step, 16u);
}

TEST(ForceShape, SeesANotchThatTheForceFallsIntoByAndBy) {
  // No single step more than halves the force.
  const ForceShape shape = JudgeForce(Steady({9.0, 6.0, 4.0, 3.0, 4.0, 6.0, 8.0}));
  ASSERT_EQ(shape.notches.size(), 1u);
  EXPECT_EQ(shape.notches.front().before, 9.0);
  EXPECT_EQ(shape.notches.front().least, 3.0);
  EXPECT_EQ(shape.notches.front().steps(), 4u);
  EXPECT_TRUE(shape.ledges.empty());
}

TEST(ForceShape, BeginsANotchWhereTheForceJumps) {
  // Gradually from 3.2 to 2.9 N, then nothing for one step.
  const ForceNotch slow = Deepest(JudgeForce(Steady({3.2, 3.1, 3.0, 2.9, 0.0, 3.2})).notches);
  EXPECT_EQ(slow.before, 2.9);
  EXPECT_EQ(slow.steps(), 1u);
  const ForceNotch stepped = Deepest(JudgeForce(Steady({5.0, 3.0, 0.0, 5.0})).notches);
  EXPECT_EQ(stepped.before, 5.0);
  EXPECT_EQ(stepped.steps(), 2u);
}

TEST(ForceShape, CountsTwoNotchesWhereTheForceIsBackBetweenThem) {
  const ForceShape shape = JudgeForce(Steady({18.1, 0.0, 0.0, 0.0, 20.1, 0.0, 19.6}));
  ASSERT_EQ(shape.notches.size(), 2u);
  EXPECT_EQ(shape.notches[0].steps(), 3u);
  EXPECT_EQ(shape.notches[1].steps(), 1u);
  EXPECT_EQ(Longest(shape.notches).begin, shape.notches[0].begin);
  EXPECT_EQ(Deepest(shape.notches).begin, shape.notches[1].begin) << "20.1 N against 18.1 N";
  EXPECT_TRUE(shape.ledges.empty());
}

TEST(ForceShape, TakesAChangeThatStaysForALedge) {
  for (const double after : {0.0, 2.0, 9.0}) {
    const ForceShape shape = JudgeForce(Steady({5.0, after}));
    EXPECT_TRUE(shape.notches.empty()) << after;
    EXPECT_TRUE(shape.passing.empty()) << after;
    ASSERT_EQ(shape.ledges.size(), 1u) << after;
    EXPECT_EQ(shape.ledges.front().step, 13u);
    EXPECT_EQ(shape.ledges.front().size, std::abs(5.0 - after));
  }
}

TEST(ForceShape, TakesAFallToMoreThanHalfOrForLongForNoNotch) {
  EXPECT_TRUE(JudgeForce(Steady({5.0, 2.6, 5.0})).notches.empty());
  EXPECT_TRUE(JudgeForce(Steady({5.0, 0.0, 2.9})).notches.empty());
  std::vector<Vec3> force = Steady({5.0, 0.0});
  force.push_back(5.0 * Vec3::UnitX());  // after 13 ms
  const ForceShape shape = JudgeForce(force);
  EXPECT_TRUE(shape.notches.empty());
  EXPECT_EQ(Largest(shape.ledges).size, 5.0);
}

TEST(ForceShape, SeesANotchOfTenMillisecondsAndNoneOfEleven) {
  const auto hole = [](int steps) {
    std::vector<Vec3> force(12, Vec3::UnitX());
    force.insert(force.end(), static_cast<std::size_t>(steps), Vec3::Zero());
    force.insert(force.end(), 12, Vec3::UnitX());
    return JudgeForce(force).notches.size();
  };
  EXPECT_EQ(hole(10), 1u);
  EXPECT_EQ(hole(11), 0u);
}

TEST(ForceShape, JudgesOnlyWhatHasEndedAtTheEnd) {
  const ForceShape back = JudgeForce(Along({5.0, 5.0, 0.0, 5.0}));
  EXPECT_EQ(back.notches.size(), 1u);
  const ForceShape open = JudgeForce(Along({5.0, 5.0, 0.0, 0.0}));
  EXPECT_TRUE(open.notches.empty());
  EXPECT_TRUE(open.ledges.empty());
  EXPECT_EQ(open.largest_jump.size, 5.0);
  EXPECT_TRUE(JudgeForce({}).notches.empty());
}

TEST(ForceShape, KnowsALedgeBesideANotch) {
  // The tool snaps, and two steps later loses its contacts for one step.
  const ForceShape shape = JudgeForce(Steady({2.0, 6.0, 6.0, 0.0, 6.0}));
  ASSERT_EQ(shape.notches.size(), 1u);
  EXPECT_EQ(shape.notches.front().before, 6.0);
  ASSERT_EQ(shape.ledges.size(), 1u);
  EXPECT_EQ(shape.ledges.front().size, 4.0);
}

TEST(ForceShape, TakesAChangeThatIsUndoneForOneThatPasses) {
  std::vector<Vec3> turned(12, Vec3(5.0, 0.0, 0.0));
  turned.push_back({0.0, 5.0, 0.0});
  turned.insert(turned.end(), 12, Vec3(5.0, 0.0, 0.0));
  for (const std::vector<Vec3>& force : {Steady({5.0, 12.0, 12.0, 5.0}), turned}) {
    const ForceShape shape = JudgeForce(force);
    EXPECT_TRUE(shape.notches.empty());
    EXPECT_TRUE(shape.ledges.empty());
    EXPECT_EQ(shape.passing.size(), 1u);
  }
}

TEST(ForceShape, LeavesToTheHandWhatTheHandCanHaveDone) {
  // A tap: 5 N away and back, at up to 2 N per millisecond.
  const std::vector<Vec3> tap = Steady({5.0, 3.0, 1.0, 1.0, 3.0, 5.0});
  EXPECT_EQ(JudgeForce(tap).notches.size(), 1u);
  std::vector<double> by_hand(tap.size(), 2.1);
  EXPECT_TRUE(JudgeForce(tap, by_hand).notches.empty());
  EXPECT_TRUE(JudgeForce(tap, by_hand).ledges.empty());
  // With so slow a hand the force falls off a ledge; then the hand returns as fast as it can.
  by_hand.assign(tap.size(), 0.1);
  by_hand[16] = by_hand[17] = 3.0;
  EXPECT_TRUE(JudgeForce(tap, by_hand).notches.empty());
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
    EXPECT_GT(shape.largest_jump.size, 0.1);
  }
}

}  // namespace
}  // namespace palpate::test
