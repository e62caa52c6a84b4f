#include "common/json/pose_script.h"

#include <cmath>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::HasSubstr;

PoseScript TwoKeys() {
  return PoseScript(
      {{0.0, Pose{}, "go"}, {2.0, Pose{Vec3(1, 0, 0), RotationExp(Vec3(0, 0, 1.0))}, "stay"}});
}

PoseScript FromText(const std::string& text) {
  return PoseScript::Parse(text, "script.json");
}

TEST(PoseScript, FollowsTheMinimumJerkPolynomial) {
  const PoseScript script = TwoKeys();
  for (const double u : {0.1, 0.25, 0.5, 0.9}) {
    const double s = 10 * std::pow(u, 3) - 15 * std::pow(u, 4) + 6 * std::pow(u, 5);
    const Pose pose = script.At(2.0 * u);
    EXPECT_NEAR(pose.p.x(), s, 1e-14);
    EXPECT_NEAR((RotationLog(pose.q) - Vec3(0, 0, s)).norm(), 0.0, 1e-14);
  }
}

TEST(PoseScript, StartsAndEndsEachSegmentAtRest) {
  const PoseScript script = TwoKeys();
  EXPECT_LT(script.At(1e-3).p.norm() / 1e-3, 1e-4);
  EXPECT_LT((script.At(2.0).p - script.At(2.0 - 1e-3).p).norm() / 1e-3, 1e-4);
}

TEST(PoseScript, HoldsTheFirstAndLastPose) {
  const PoseScript script = TwoKeys();
  EXPECT_EQ(script.At(-1.0).p, Vec3(0, 0, 0));
  EXPECT_EQ(script.At(99.0).p, Vec3(1, 0, 0));
  EXPECT_EQ(script.At(std::nan("")).p, Vec3(0, 0, 0));
  EXPECT_EQ(script.LabelAt(-1.0), "go");
  EXPECT_EQ(script.LabelAt(1.999), "go");
  EXPECT_EQ(script.LabelAt(2.0), "stay");
}

TEST(PoseScript, TurnsTheShorterWayWhateverTheSignOfTheQuaternion) {
  const Quat q = RotationExp(Vec3(0, 0, 1.0));
  const PoseScript script({{0.0, Pose{}, ""}, {1.0, Pose{Vec3::Zero(), Quat(-q.coeffs())}, ""}});
  EXPECT_NEAR(RotationLog(script.At(0.5).q).z(), 0.5, 1e-14);
}

TEST(PoseScript, ReadsAFileAndCarriesOnWhatAKeyLeavesOut) {
  const PoseScript script = FromText(R"({"keys": [
    {"t": 0, "position_mm": [10, 0, 0], "label": "approach"},
    {"t": 1, "rotation_deg": {"axis": [0, 1, 0], "angle": 180}},  // comments are fine
    {"t": 2, "position_mm": [0, 0, 5]}]})");
  ASSERT_EQ(script.keys().size(), 3u);
  EXPECT_EQ(script.keys()[1].X_WH.p, Vec3(0.01, 0, 0));
  EXPECT_EQ(script.keys()[2].X_WH.q.coeffs(), script.keys()[1].X_WH.q.coeffs());
  EXPECT_EQ(script.keys()[2].label, "approach");
}

TEST(PoseScript, RefusesKeysOutOfOrder) {
  const auto complaint = [](const std::string& text) {
    return test::ComplaintOf([&] { FromText(text); });
  };
  EXPECT_THAT(complaint("{\"keys\": []}"), HasSubstr("keys: has 0 entries; give at least 1"));
  EXPECT_THAT(complaint("{\"keys\": [{\"t\": 1}]}"), HasSubstr("keys[0].t: the first key"));
  EXPECT_THAT(complaint("{\"keys\": [{\"t\": 0},\n{\"t\": 0}]}"),
              HasSubstr("script.json:2: keys[1].t: is not after"));
  EXPECT_THAT(complaint("{\"keys\": [{\"t\": 0, \"pos\": [0,0,0]}]}"), HasSubstr("no such field"));
  EXPECT_THROW(PoseScript({}), Error);
}

}  // namespace
}  // namespace palpate
