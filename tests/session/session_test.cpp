#include "server/session/session.h"

#include <gmock/gmock.h>

#include "tests/session/ball_tool.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class SessionTest : public testing::Test {
 protected:
  wire::Wrench Send(double z) {
    wire::Wrench answer{};
    session_.loop().OnPose(hand_.At(z), answer);
    return answer;
  }
  /// One millisecond with a pose.
  bool Tick(double z) {
    Send(z);
    return session_.Update(now_ += kMs);
  }

  std::int64_t now_ = 1000 * kMs;
  Hand hand_;
  Session session_{"left", 7, BallTool(), now_};
};

TEST_F(SessionTest, WaitsForTheFirstPose) {
  EXPECT_EQ(session_.phase(), palpate_SESSION_WAITING);
  EXPECT_FALSE(session_.Update(now_ += 4900 * kMs));
  EXPECT_EQ(session_.phase(), palpate_SESSION_WAITING);
  EXPECT_TRUE(Tick(0.1));
  EXPECT_EQ(session_.phase(), palpate_SESSION_ACTIVE);
  EXPECT_EQ(session_.start_depth(), 0.0);
}

TEST_F(SessionTest, EndsWhereNoPoseComes) {
  EXPECT_TRUE(session_.Update(now_ += Session::kFirstPose_ns + 1));
  EXPECT_TRUE(session_.ended());
  EXPECT_THAT(session_.reason(), HasSubstr("no pose"));
  EXPECT_FALSE(session_.Update(now_ += kMs));
}

TEST_F(SessionTest, WaitsForAStationThatStillAsks) {
  session_.HearAsking(now_ += Session::kFirstPose_ns);
  EXPECT_FALSE(session_.Update(now_ += Session::kFirstPose_ns));
  Tick(0.1);
  session_.HearAsking(now_ += Session::kSilence_ns);
  EXPECT_TRUE(session_.Update(now_ += 1)) << "it has sent poses, and asking is none";
  EXPECT_TRUE(session_.ended());
}

TEST_F(SessionTest, IsToldToStartBeforeTheFirstForce) {
  EXPECT_TRUE(Tick(0.1));
  EXPECT_EQ(session_.phase(), palpate_SESSION_ACTIVE);
  EXPECT_EQ(Send(0.1).faults, kFaultNotStarted) << "who records has not heard of it yet";
  session_.Update(now_ += kMs);
  EXPECT_EQ(Send(0.1).faults, kFaultNone);
}

TEST_F(SessionTest, EndsWhereTheStationFallsSilent) {
  Tick(0.1);
  EXPECT_FALSE(session_.Update(now_ += Session::kSilence_ns));
  EXPECT_TRUE(session_.Update(now_ += 1));
  EXPECT_TRUE(session_.ended());
  EXPECT_THAT(session_.reason(), HasSubstr("100 ms"));
}

TEST_F(SessionTest, WaitsLongerForAMouseWhoseHandFeelsNothing) {
  Session mouse("mouse", 8, BallTool(), now_, {.below_arms = true});
  wire::Wrench answer{};
  mouse.loop().OnPose(hand_.At(0.1), answer);
  EXPECT_FALSE(mouse.ended());
  mouse.Update(now_ += kMs);
  EXPECT_FALSE(mouse.Update(now_ += Session::kMouseSilence_ns));
  EXPECT_FALSE(mouse.ended()) << "twenty of them on two cores are held up for a fraction of that";
  EXPECT_TRUE(mouse.Update(now_ += 1));
  EXPECT_THAT(mouse.reason(), HasSubstr("1000 ms"));
}

TEST_F(SessionTest, TakesRepeatedPosesForSilence) {
  const wire::HapticPose pose = hand_.At(0.1);
  wire::Wrench answer{};
  for (int i = 0; i < 200 && !session_.ended(); ++i) {
    session_.loop().OnPose(pose, answer);
    session_.Update(now_ += kMs);
  }
  EXPECT_TRUE(session_.ended());
}

TEST_F(SessionTest, StartsAShallowTouchOutsideTheObjectAndLetsTheForceIn) {
  EXPECT_TRUE(Tick(kTouch - 0.006));
  EXPECT_EQ(session_.phase(), palpate_SESSION_ACTIVE);
  EXPECT_NEAR(session_.start_depth(), 0.006, 1e-4);
  session_.Update(now_ += kMs);
  double last = 0.0;
  wire::Wrench answer{};
  for (int i = 0; i < 250; ++i) {
    answer = Send(kTouch - 0.006);
    EXPECT_LE(answer.force_N[2] - last, 6.0 / 200 + 1e-6) << "no step";
    last = answer.force_N[2];
  }
  EXPECT_NEAR(answer.force_N[2], 6.0, 1e-4);
  EXPECT_NEAR(answer.graphic_position_m[2], kTouch, 1e-6);
}

TEST_F(SessionTest, GivesNoForceDeepInsideSaysTheDepthAndStartsOnceTheHandIsOut) {
  EXPECT_TRUE(Tick(0.020));
  EXPECT_EQ(session_.phase(), palpate_SESSION_ACQUIRING);
  EXPECT_NEAR(session_.start_depth(), kTouch - 0.020, 1e-3);
  EXPECT_THAT(session_.reason(), HasSubstr("35 mm inside an object"));
  EXPECT_THAT(session_.reason(), HasSubstr("move the hand back"));
  double z = 0.020;
  while (session_.phase() == palpate_SESSION_ACQUIRING && z < 0.1) {
    const wire::Wrench answer = Send(z);
    EXPECT_EQ(answer.faults, kFaultNotStarted);
    EXPECT_EQ(wire::ToWrench(answer).force, Vec3::Zero());
    session_.Update(now_ += kMs);
    z += 0.0001;
  }
  EXPECT_EQ(session_.phase(), palpate_SESSION_ACTIVE);
  EXPECT_GT(z, kTouch - Session::kMaxStartDepth_m - 1e-3);
  EXPECT_EQ(session_.reason(), "");
  session_.Update(now_ += kMs);
  EXPECT_EQ(Send(z).faults, kFaultNone);
}

TEST_F(SessionTest, IsNotStartedByAPoseThatIsNone) {
  wire::Wrench answer{};
  wire::HapticPose pose = hand_.At(0.1);
  pose.orientation_wxyz[0] = 0.0;
  session_.loop().OnPose(pose, answer);
  EXPECT_FALSE(session_.Update(now_ += kMs));
  EXPECT_EQ(session_.phase(), palpate_SESSION_WAITING);
}

}  // namespace
}  // namespace palpate::test
