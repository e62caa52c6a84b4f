#include "server/session/servo_loop.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "tests/session/ball_tool.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kPressed = kTouch - 0.004;  // 4 N
constexpr double kFull_N = 4.0;

class ServoLoopTest : public testing::Test {
 protected:
  wire::Wrench Send(const wire::HapticPose& pose) {
    wire::Wrench answer{};
    EXPECT_TRUE(loop_.OnPose(pose, answer));
    return answer;
  }
  bool Answers(const wire::HapticPose& pose) {
    wire::Wrench answer{};
    return loop_.OnPose(pose, answer);
  }
  /// Presses until the force is full.
  void Press() {
    loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
    for (int i = 0; i < 250; ++i) last_N_ = Send(hand_.At(kPressed)).force_N[2];
    ASSERT_NEAR(last_N_, kFull_N, 1e-5);
  }
  /// Sends one more pose and checks that the force does not jump: it rises by at most 1/200 of the
  /// full force, and falls by at most 1/20.
  wire::Wrench SendSmoothly(const wire::HapticPose& pose) {
    const wire::Wrench answer = Send(pose);
    EXPECT_LE(answer.force_N[2] - last_N_, kFull_N / 200 + 1e-6);
    EXPECT_GE(answer.force_N[2] - last_N_, -kFull_N / 20 - 1e-6);
    last_N_ = answer.force_N[2];
    return answer;
  }
  LoopCounters Counters() {
    loop_.RequestCounters();
    Send(hand_.At(kPressed));
    LoopCounters counters;
    EXPECT_TRUE(loop_.ReadCounters(counters));
    return counters;
  }

  std::shared_ptr<const ServedTool> tool_ = BallTool();
  ServoLoop loop_{tool_->model};
  Hand hand_;
  double last_N_ = 0.0;
};

TEST_F(ServoLoopTest, AnswersAPoseWithItsNumberAndTime) {
  hand_.sequence = 41;
  const wire::Wrench answer = Send(hand_.At(0.1));
  EXPECT_EQ(answer.pose_sequence, 42u);
  EXPECT_EQ(answer.pose_time_ns, 42'000'000);
  EXPECT_GE(answer.step_time_s, 0.0);
  EXPECT_GT(answer.valid_s, 0.0);
}

TEST_F(ServoLoopTest, GivesNoForceBeforeItIsStarted) {
  for (int i = 0; i < 300; ++i) {
    const wire::Wrench answer = Send(hand_.At(0.01));  // deep inside
    EXPECT_EQ(wire::ToWrench(answer).force, Vec3::Zero());
    EXPECT_EQ(answer.faults, kFaultNotStarted);
    EXPECT_EQ(answer.graphic_position_m[2], 0.01);
  }
}

TEST_F(ServoLoopTest, NumbersItsAnswersWhateverTheStationCallsItsPoses) {
  for (const std::uint64_t sequence : {3u, 4u, 9u}) {
    hand_.sequence = sequence;
    Send(hand_.At(0.1));
  }
  hand_.sequence = 4;
  EXPECT_FALSE(Answers(hand_.At(0.1)));
  hand_.sequence = 20;
  EXPECT_EQ(Send(hand_.At(0.1)).answer, 4u);
}

TEST_F(ServoLoopTest, SaysWhichPoseItWasStartedWith) {
  Send(hand_.At(0.1));
  EXPECT_EQ(loop_.start_sequence(), 0u);
  loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  EXPECT_EQ(loop_.start_sequence(), 0u) << "not before a pose";
  hand_.sequence = 41;
  EXPECT_EQ(Send(hand_.At(0.1)).faults & kFaultNotStarted, 0u);
  Send(hand_.At(0.1));
  EXPECT_EQ(loop_.start_sequence(), 42u);
}

TEST_F(ServoLoopTest, LetsTheForceInOverTwoHundredSamples) {
  loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  for (int i = 1; i <= 300; ++i) {
    const wire::Wrench answer = Send(hand_.At(kPressed));
    const double gain = std::min(1.0, i / 200.0);
    EXPECT_NEAR(answer.force_N[2], gain * kFull_N, 1e-5) << i;
    EXPECT_NEAR(answer.graphic_position_m[2], kTouch, 1e-8);
  }
}

TEST_F(ServoLoopTest, GivesTheLocalModelOnlyWithTheFullForce) {
  loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  for (int i = 1; i <= 250; ++i) {
    const wire::Wrench answer = Send(hand_.At(kPressed));
    EXPECT_EQ(answer.contacts, 1u);
    if (answer.force_N[2] < kFull_N - 1e-5) {
      EXPECT_EQ(answer.rows, 0u);
      EXPECT_EQ(answer.region_m, 0.0);
    }
  }
  const wire::Wrench answer = Send(hand_.At(kPressed));
  ASSERT_EQ(answer.rows, 1u);
  EXPECT_GE(answer.region_m, 1e-3);          // a hand at 0.1 m/s within 10 ms
  EXPECT_GE(answer.region_rad, 3.0);         // a ball may turn
  EXPECT_NEAR(answer.row[0][2], 1.0, 1e-9);  // the ball's normal points up
  EXPECT_NEAR(answer.row_offset_m[0], 0.0, 1e-8);
  EXPECT_NEAR(answer.row_force_N[0], kFull_N, 1e-5);
}

struct BadPose {
  const char* name;
  void (*spoil)(wire::HapticPose&);
};

class ServoLoopWithBadPose : public ServoLoopTest, public testing::WithParamInterface<BadPose> {};

TEST_P(ServoLoopWithBadPose, HoldsTheToolAndFadesTheForceAndComesBack) {
  Press();
  for (int i = 0; i < 30; ++i) {
    wire::HapticPose pose = hand_.At(kPressed);
    GetParam().spoil(pose);
    const wire::Wrench answer = SendSmoothly(pose);
    EXPECT_EQ(answer.faults, kFaultBadPose);
    EXPECT_NEAR(answer.graphic_position_m[2], kTouch, 1e-8);
    EXPECT_EQ(answer.rows, 0u);
  }
  EXPECT_EQ(last_N_, 0.0);
  for (int i = 0; i < 250; ++i) SendSmoothly(hand_.At(kPressed));
  EXPECT_NEAR(last_N_, kFull_N, 1e-5);
  EXPECT_EQ(Counters().rejected_nonfinite, 30u);
}

TEST_P(ServoLoopWithBadPose, IsNotStartedByIt) {
  wire::HapticPose pose = hand_.At(kPressed);
  GetParam().spoil(pose);
  EXPECT_EQ(Send(pose).faults, kFaultBadPose | kFaultNotStarted);
  LoopSnapshot snapshot;
  ASSERT_TRUE(loop_.ReadSnapshot(snapshot));
  EXPECT_FALSE(snapshot.has_pose);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, ServoLoopWithBadPose,
    testing::Values(
        BadPose{"PositionNaN", [](wire::HapticPose& p) { p.position_m[1] = kNaN; }},
        BadPose{"PositionInfinite", [](wire::HapticPose& p) { p.position_m[0] = -kInf; }},
        BadPose{"PositionHuge", [](wire::HapticPose& p) { p.position_m[2] = 1e300; }},
        BadPose{"RotationNaN", [](wire::HapticPose& p) { p.orientation_wxyz[3] = kNaN; }},
        BadPose{"RotationInfinite", [](wire::HapticPose& p) { p.orientation_wxyz[0] = kInf; }},
        BadPose{"RotationWithoutLength", [](wire::HapticPose& p) { p.orientation_wxyz[0] = 0.0; }}),
    [](const auto& test_case) { return test_case.param.name; });

TEST_F(ServoLoopTest, NormalisesAQuaternionAndCountsIt) {
  Press();
  wire::HapticPose pose = hand_.At(kPressed);
  pose.orientation_wxyz[0] = 1.05;
  const wire::Wrench answer = SendSmoothly(pose);
  EXPECT_EQ(answer.faults, kFaultNone);
  EXPECT_NEAR(answer.force_N[2], kFull_N, 1e-5);
  const LoopCounters counters = Counters();
  EXPECT_EQ(counters.renormalised, 1u);
  EXPECT_EQ(counters.rejected_nonfinite, 0u);
}

TEST_F(ServoLoopTest, TakesAQuaternionAndItsNegativeForTheSame) {
  Press();
  wire::HapticPose pose = hand_.At(kPressed);
  pose.orientation_wxyz[0] = -1.0;
  EXPECT_EQ(SendSmoothly(pose).faults, kFaultNone);
}

TEST_F(ServoLoopTest, DoesNotAnswerRepeatsAndLatecomersAndIsNotMovedByThem) {
  Press();
  const wire::HapticPose late = hand_.At(kTouch + 0.001);
  const wire::HapticPose on_time = hand_.At(kPressed);
  SendSmoothly(on_time);
  EXPECT_FALSE(Answers(on_time));
  EXPECT_FALSE(Answers(late));
  wire::HapticPose clock_stands = hand_.At(kPressed);
  clock_stands.sample_time_ns = on_time.sample_time_ns;
  EXPECT_FALSE(Answers(clock_stands));
  const std::uint64_t heard = loop_.heard();
  EXPECT_FALSE(Answers(on_time));
  EXPECT_EQ(loop_.heard(), heard);
  EXPECT_NEAR(SendSmoothly(hand_.At(kPressed)).force_N[2], kFull_N, 1e-5);
  EXPECT_EQ(Counters().rejected_sequence, 4u);
}

TEST_F(ServoLoopTest, CountsWhatIsLostAndGoesOn) {
  Press();
  hand_.sequence += 7;
  SendSmoothly(hand_.At(kPressed));
  EXPECT_EQ(Counters().lost, 7u);
}

TEST_F(ServoLoopTest, IgnoresAStrayPose) {
  Press();
  for (int stray = 1; stray < 5; ++stray) {  // too few to make a jump credible
    for (int i = 0; i < stray; ++i) {
      const wire::Wrench answer = SendSmoothly(hand_.At(Vec3(0.3, 0, 0.2)));
      EXPECT_EQ(answer.faults, kFaultPoseRejected);
      EXPECT_NEAR(answer.graphic_position_m[2], kTouch, 1e-8);
    }
    for (int i = 0; i < 50; ++i) SendSmoothly(hand_.At(kPressed));
  }
  EXPECT_NEAR(last_N_, kFull_N, 1e-5);
  EXPECT_EQ(Counters().rejected_speed, 1u + 2u + 3u + 4u);
}

TEST_F(ServoLoopTest, IgnoresStrayPosesThatDoNotAgree) {
  Press();
  for (int i = 0; i < 40; ++i) {  // after that a hand could be anywhere
    const double side = i % 2 == 0 ? 0.3 : -0.3;
    EXPECT_EQ(SendSmoothly(hand_.At(Vec3(side, 0, 0.2))).faults, kFaultPoseRejected);
  }
}

TEST_F(ServoLoopTest, FollowsAHandThatReallyIsElsewhere) {
  Press();
  // The hand goes from above the ball to beside it.  It is believed after five samples; then the
  // tool travels there, and the force starts from zero.
  const Vec3 beside(0.2, 0, 0);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(SendSmoothly(hand_.At(beside)).faults, kFaultPoseRejected);
  const wire::Wrench believed = Send(hand_.At(beside));
  EXPECT_EQ(believed.faults & kFaultPoseRejected, 0u);
  EXPECT_LT(wire::ToWrench(believed).force.norm(), 2.0);
  wire::Wrench answer{};
  for (int i = 0; i < 300; ++i) answer = Send(hand_.At(beside));
  EXPECT_NEAR(answer.graphic_position_m[0], 0.2, 1e-6);
  EXPECT_EQ(answer.faults, kFaultNone);
}

TEST_F(ServoLoopTest, BoundsTheHandsSpeedAtFiveMetresASecond) {
  loop_.Start({Vec3(0, 0, 0.2), Quat::Identity()});
  double z = 0.2;
  EXPECT_EQ(Send(hand_.At(z)).faults, kFaultNone);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(Send(hand_.At(z += 0.00499)).faults & kFaultPoseRejected, 0u);
  }
  EXPECT_EQ(Send(hand_.At(z += 0.00501)).faults, kFaultPoseRejected);
}

TEST_F(ServoLoopTest, BoundsTheHandsTurnAtAHundredRadiansASecond) {
  loop_.Start({Vec3(0, 0, 0.2), Quat::Identity()});
  Send(hand_.At(0.2));
  const auto turned = [&](double angle) {
    wire::HapticPose pose = hand_.At(0.2);
    pose.orientation_wxyz[0] = std::cos(angle / 2);
    pose.orientation_wxyz[1] = std::sin(angle / 2);
    return pose;
  };
  EXPECT_EQ(Send(turned(0.099)).faults & kFaultPoseRejected, 0u);
  EXPECT_EQ(Send(turned(0.099 + 0.101)).faults, kFaultPoseRejected);
}

TEST_F(ServoLoopTest, GivesAHandTimeToHaveMovedWhileSamplesWereLost) {
  loop_.Start({Vec3(0, 0, 0.2), Quat::Identity()});
  Send(hand_.At(0.2));
  hand_.sequence += 9;
  EXPECT_EQ(Send(hand_.At(0.2 + 0.049)).faults & kFaultPoseRejected, 0u);
}

TEST_F(ServoLoopTest, StandsAClockThatIsBroken) {
  wire::HapticPose pose = hand_.At(0.1);
  pose.sample_time_ns = std::numeric_limits<std::int64_t>::min();
  Send(pose);
  pose = hand_.At(0.1);
  pose.sample_time_ns = std::numeric_limits<std::int64_t>::max();
  Send(pose);
  EXPECT_FALSE(Answers(hand_.At(0.1)));
}

TEST_F(ServoLoopTest, GivesEqualBitsForEqualPoses) {
  ServoLoop other(tool_->model);
  Random random(3);
  loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  other.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  for (int i = 0; i < 2000; ++i) {
    wire::HapticPose pose = hand_.At(Vec3(0, 0, kPressed) + random.InCube(0.002));
    if (random.Below(20) == 0) pose.position_m[0] = kNaN;
    if (random.Below(20) == 0) pose.position_m[0] += 1.0;
    wire::Wrench a{};
    wire::Wrench b{};
    EXPECT_EQ(loop_.OnPose(pose, a), other.OnPose(pose, b));
    a.step_time_s = b.step_time_s = 0.0;
    EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
  }
}

TEST_F(ServoLoopTest, AllocatesNothing) {
  Press();
  wire::Wrench answer{};
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 1000; ++i) {
    wire::HapticPose pose = hand_.At(kPressed + 0.006 * (i % 2));
    if (i % 10 == 0) pose.position_m[0] = kNaN;
    if (i % 100 == 0) loop_.RequestCounters();
    loop_.OnPose(pose, answer);
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

TEST_F(ServoLoopTest, ReportsCountersOnceForEachRequest) {
  Press();
  LoopCounters counters;
  EXPECT_FALSE(loop_.ReadCounters(counters));
  counters = Counters();
  EXPECT_EQ(counters.poses, 251u);
  EXPECT_EQ(counters.steps, 251u);
  EXPECT_EQ(counters.step.count(), 251u);
  EXPECT_FALSE(loop_.ReadCounters(counters));
  EXPECT_EQ(Counters().poses, 1u);
}

TEST_F(ServoLoopTest, IsStartedAndWatchedFromAnotherThread) {
  // The loop runs until the watcher has seen enough, however the two are scheduled.
  constexpr int kSeen = 200, kMost = 2'000'000;
  std::atomic<bool> enough{false};
  std::atomic<int> sent{0};
  std::thread servo([&] {
    wire::Wrench answer{};
    while (!enough && sent < kMost) {
      loop_.OnPose(hand_.At(kPressed), answer);
      ++sent;
    }
  });
  LoopSnapshot snapshot;
  LoopCounters counters;
  std::uint64_t sequence = 0, poses = 0;
  int snapshots = 0, reports = 0, starts = 0;
  loop_.RequestCounters();
  while (sent < kMost && (snapshots < kSeen || reports < kSeen)) {
    loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
    ++starts;
    if (loop_.ReadSnapshot(snapshot)) {
      EXPECT_GT(snapshot.pose_sequence, sequence);
      EXPECT_EQ(snapshot.X_WH.p, Vec3(0, 0, kPressed));
      sequence = snapshot.pose_sequence;
      ++snapshots;
    }
    if (loop_.ReadCounters(counters)) {
      poses += counters.poses;
      ++reports;
      loop_.RequestCounters();
    }
    std::this_thread::yield();
  }
  enough = true;
  servo.join();
  EXPECT_GE(snapshots, kSeen);
  EXPECT_GE(reports, kSeen);
  EXPECT_GE(starts, kSeen);
  EXPECT_GT(loop_.start_sequence(), 0u);
  // What was in no report yet is in the next: no pose is counted twice or left out.
  if (loop_.ReadCounters(counters)) poses += counters.poses;
  poses += Counters().poses;
  const auto all = static_cast<std::uint64_t>(sent) + 1;
  EXPECT_EQ(poses, all);
  EXPECT_EQ(loop_.heard(), all);
  ASSERT_TRUE(loop_.ReadSnapshot(snapshot));
  EXPECT_EQ(snapshot.pose_sequence, all);
}

TEST_F(ServoLoopTest, ShowsViewersItsLastStep) {
  Press();
  LoopSnapshot snapshot;
  ASSERT_TRUE(loop_.ReadSnapshot(snapshot));
  EXPECT_TRUE(snapshot.has_pose);
  EXPECT_EQ(snapshot.pose_sequence, 250u);
  EXPECT_EQ(snapshot.X_WH.p, Vec3(0, 0, kPressed));
  EXPECT_NEAR(snapshot.X_WG.p.z(), kTouch, 1e-8);
  EXPECT_NEAR(snapshot.wrench.force.z(), kFull_N, 1e-5);
  EXPECT_EQ(snapshot.contacts, 1u);
  EXPECT_GT(snapshot.step_s, 0.0);
  ASSERT_EQ(snapshot.points, 1);
  EXPECT_LT((snapshot.point[0].point - Vec3(0, 0, kBallRadius)).norm(), 1e-8);
  EXPECT_LT((snapshot.point[0].force - Vec3(0, 0, kFull_N)).norm(), 1e-5);
  EXPECT_FALSE(loop_.ReadSnapshot(snapshot));
}

TEST_F(ServoLoopTest, ShowsTheContactsForcesAsTheyAreSentAndNoneWhileTheToolIsHeld) {
  loop_.Start({Vec3(0, 0, kTouch), Quat::Identity()});
  LoopSnapshot snapshot;
  for (int i = 0; i < 250; ++i) {
    const wire::Wrench answer = Send(hand_.At(kPressed));
    ASSERT_TRUE(loop_.ReadSnapshot(snapshot));
    ASSERT_EQ(snapshot.points, 1);
    EXPECT_NEAR(snapshot.point[0].force.z(), answer.force_N[2], 1e-9);
  }
  wire::HapticPose lost = hand_.At(kPressed);
  lost.position_m[0] = kNaN;
  EXPECT_GT(Send(lost).force_N[2], 0.0);
  ASSERT_TRUE(loop_.ReadSnapshot(snapshot));
  EXPECT_EQ(snapshot.points, 0);
}

}  // namespace
}  // namespace palpate::test
