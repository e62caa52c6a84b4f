#include <numbers>
#include <string>

#include <gmock/gmock.h>

#include "client/doctor/checks.h"
#include "common/math/rotation.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;

constexpr double kWay_m = 2e-3;
constexpr double kDegree = std::numbers::pi / 180.0;

Mat3 Turned(const Vec3& by_rad) {
  return kWay_m * RotationExp(by_rad).toRotationMatrix();
}

TEST(JudgePush, AcceptsAHandleThatGivesWayWhereItIsPushed) {
  EXPECT_EQ(JudgePush(1.0, kWay_m * Mat3::Identity()).status, Status::kOk);
  // A mechanism does not give way equally in all directions, nor exactly along the push.
  Mat3 uneven = kWay_m * Mat3::Identity();
  uneven(0, 0) *= 3.0;
  uneven(0, 1) = uneven(1, 0) = 0.5 * kWay_m;
  EXPECT_EQ(JudgePush(1.0, uneven).status, Status::kOk);
  EXPECT_EQ(JudgePush(1.0, Turned(20.0 * kDegree * Vec3::UnitZ())).status, Status::kOk);
}

TEST(JudgePush, NamesTheAxisThatMovesInsteadWhereTwoAreExchanged) {
  for (int fixed = 0; fixed < 3; ++fixed) {
    Mat3 way = kWay_m * Mat3::Identity();
    way.col((fixed + 1) % 3).swap(way.col((fixed + 2) % 3));
    const Finding finding = JudgePush(1.0, way);
    EXPECT_EQ(finding.status, Status::kFault);
    const std::string axes = "xyz";
    const char first = axes[(fixed + 1) % 3], second = axes[(fixed + 2) % 3];
    for (const auto& [pushed, moved] : {std::pair{first, second}, std::pair{second, first},
                                        std::pair{axes[fixed], axes[fixed]}}) {
      EXPECT_THAT(finding.found, HasSubstr(std::string(" along ") + pushed +
                                           ", the handle moved 2.0 mm along " + moved));
    }
  }
}

TEST(JudgePush, FindsAnAxisThatIsReversed) {
  for (int axis = 0; axis < 3; ++axis) {
    Mat3 way = kWay_m * Mat3::Identity();
    way(axis, axis) *= -1.0;
    const Finding finding = JudgePush(1.0, way);
    EXPECT_EQ(finding.status, Status::kFault);
    EXPECT_THAT(finding.found, HasSubstr(std::string("along -") + "xyz"[axis]));
  }
}

TEST(JudgePush, FindsAFrameThatIsTurned) {
  for (const Vec3& about : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
    for (const double angle : {45.0, -45.0, 90.0, 135.0, 180.0}) {
      const Finding finding = JudgePush(1.0, Turned(angle * kDegree * about));
      EXPECT_EQ(finding.status, Status::kFault) << angle << ' ' << about.transpose();
    }
  }
}

TEST(JudgePush, DoubtsAFrameThatIsTurnedALittleWhateverTheHandlesInertia) {
  const Mat3 inertia = Vec3(kWay_m, 3.0 * kWay_m, 2.0 * kWay_m).asDiagonal();
  for (const Vec3& about : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
    for (const double angle : {30.0, -30.0}) {
      EXPECT_EQ(JudgePush(1.0, Turned(angle * kDegree * about)).status, Status::kWarning);
    }
    // The same lever for both directions of a mechanism that is not along the axes.
    const Mat3 oblique = RotationExp(30.0 * kDegree * about).toRotationMatrix();
    EXPECT_EQ(JudgePush(1.0, oblique * inertia * oblique.transpose()).status, Status::kOk);
  }
}

TEST(JudgePush, FindsOneWrongAxisBesideOneThatDidNotMove) {
  Mat3 way = Mat3::Zero();
  way(1, 0) = kWay_m;
  EXPECT_EQ(JudgePush(1.0, way).status, Status::kFault);
}

TEST(JudgePush, AsksForAnotherTrialWhereAnAxisDidNotMove) {
  EXPECT_EQ(JudgePush(1.0, 0.1e-3 * Mat3::Identity()).status, Status::kWarning);
  Mat3 way = kWay_m * Mat3::Identity();
  way(2, 2) = 0.2e-3;
  EXPECT_EQ(JudgePush(1.0, way).status, Status::kWarning);
}

}  // namespace
}  // namespace palpate::doctor
