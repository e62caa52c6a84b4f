// A station and a server with a bad link between them, in virtual time: what must hold whatever
// link, server and device do.
#include <limits>

#include <gtest/gtest.h>

#include "tests/link/virtual_loop.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr double kForce_N = 1e3 * VirtualLoop::kDepth_m * 1.0;  // 1 N/mm
constexpr double kRounding = 1.0 + 1e-9;
constexpr int kSilent_ms = 30;  // when a force has to be gone

/// What must hold in every tick for a hand held still at a depth.
void ExpectSafe(VirtualLoop& loop, double most_N) {
  const WrenchLimits& limits = loop.core().limiter().limits();
  const Wrench& now = loop.applied();
  ASSERT_TRUE(now.force.allFinite() && now.torque.allFinite());
  ASSERT_LE(now.force.norm(), most_N * kRounding);
  ASSERT_LE(now.torque.norm(), limits.torque_Nm() * kRounding);
  ASSERT_LE((now.force - loop.before().force).norm(), limits.force_slew_N_per_ms() * kRounding);
  ASSERT_LE((now.torque - loop.before().torque).norm(), limits.torque_slew_Nm_per_ms() * kRounding);
}

LinkConditions RandomConditions(Random& random) {
  LinkConditions conditions;
  conditions.delay_ns = static_cast<std::int64_t>(random.Uniform(0.0, 15e6));
  conditions.jitter_ns = static_cast<std::int64_t>(random.Uniform(0.0, 8e6));
  conditions.loss = random.Uniform(0.0, 0.5);
  conditions.duplication = random.Uniform(0.0, 0.5);
  conditions.reordering = random.Uniform(0.0, 0.5);
  return conditions;
}

TEST(FaultyLink, NeverGivesMoreThanTheContactNorAStepBeyondTheSlewLimit) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    VirtualLoop loop(seed, RandomConditions(random));
    for (int i = 0; i < 1500; ++i) {
      if (random.Below(300) == 0) loop.link().up.conditions() = RandomConditions(random);
      if (random.Below(300) == 0) loop.link().down.conditions() = RandomConditions(random);
      loop.Tick();
      ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N)) << "seed " << seed << ", tick " << i;
    }
  }
}

TEST(FaultyLink, UsesNoReplyTwiceNorOneThatIsOlderThanTheLast) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    VirtualLoop loop(seed, RandomConditions(random));
    std::uint64_t newest = 0, used = 0;
    for (int i = 0; i < 1500; ++i) {
      loop.Tick();
      ASSERT_GE(loop.core().newest().pose_sequence, newest);
      ASSERT_LE(loop.core().newest().pose_sequence, loop.core().sequence());
      newest = loop.core().newest().pose_sequence;
    }
    used = loop.core().totals().replies;
    EXPECT_GT(used, 0u);
    // Each pose is answered at most once, and each one passed over counts as lost.
    EXPECT_EQ(used + loop.core().lost(), newest);
  }
}

TEST(FaultyLink, CountsWhatALosslessLinkDoublesAndReordersAsStraysAndLosesNothingElse) {
  LinkConditions conditions;
  conditions.delay_ns = 2'300'000;
  conditions.duplication = 0.3;
  VirtualLoop loop(7, conditions);
  loop.For(2000);
  const StationTotals& totals = loop.core().totals();
  EXPECT_EQ(loop.core().lost(), 0u);
  EXPECT_EQ(totals.late, totals.replies) << "each took 4.6 ms";
  // A duplicated pose is answered once; a duplicated answer is used once.
  EXPECT_NEAR(static_cast<double>(totals.strays), 0.3 * 2000, 100.0);
}

TEST(FaultyLink, LeavesNoForceThirtyMillisecondsAfterTheLastReplyAndComesBackByARamp) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    LinkConditions conditions;
    conditions.delay_ns = static_cast<std::int64_t>(random.Uniform(0.0, 2e6));
    VirtualLoop loop(seed, conditions);
    loop.For(1000);
    ASSERT_NEAR(loop.applied().force.z(), kForce_N, 1e-6);
    LossyWay<wire::Wrench>& down = loop.link().down;
    LossyWay<wire::HapticPose>& up = loop.link().up;
    const bool upwards = random.Below(2) == 0;  // the link may be cut either way
    (upwards ? up.conditions() : down.conditions()).loss = 1.0;
    std::uint64_t newest = 0;
    for (int silent = 0; silent <= 300; ++silent) {
      loop.Tick();
      ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
      if (loop.core().newest().pose_sequence != newest) {  // it was still on its way
        newest = loop.core().newest().pose_sequence;
        silent = 0;
      }
      ASSERT_LE(loop.applied().force.norm(), loop.before().force.norm() * kRounding);
      if (silent >= kSilent_ms) {
        ASSERT_EQ(loop.applied().force, Vec3::Zero());
      }
    }
    (upwards ? up.conditions() : down.conditions()).loss = 0.0;
    int rising = 0;
    while (loop.applied().force.norm() < 0.999 * kForce_N && rising < 2000) {
      loop.Tick();
      ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
      ++rising;
    }
    EXPECT_GE(rising, 150) << "a ramp of 200 ms";
    EXPECT_LT(rising, 1000);
  }
}

TEST(FaultyLink, LetsAServersSuccessorInByARampFromZero) {
  VirtualLoop loop(3);
  loop.For(1000);
  loop.KillServer();
  loop.For(kSilent_ms + 1);
  EXPECT_EQ(loop.applied().force, Vec3::Zero());
  loop.StartServer();
  for (int i = 0; i < 1000; ++i) {
    loop.Tick();
    ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
    // The station's ramp and the server's both take 200 ms.
    ASSERT_LE(loop.applied().force.norm(), kForce_N * std::min(1.0, (i + 2) / 200.0) * kRounding);
  }
  EXPECT_NEAR(loop.applied().force.z(), kForce_N, 1e-6);
}

TEST(FaultyLink, GivesNoForceFromTheRepliesThatAFrozenServerSendsInABurst) {
  VirtualLoop loop(4);
  loop.For(1000);
  loop.FreezeServer(true);
  loop.For(500);
  EXPECT_EQ(loop.applied().force, Vec3::Zero());
  loop.FreezeServer(false);
  loop.Tick();
  const StationTotals& totals = loop.core().totals();
  EXPECT_GE(totals.replies + totals.strays, 1400u) << "the burst came";
  EXPECT_LT(loop.applied().force.norm(), 0.02 * kForce_N);
  for (int i = 0; i < 500; ++i) {
    loop.Tick();
    ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
  }
  EXPECT_NEAR(loop.applied().force.z(), kForce_N, 1e-6);
}

TEST(LyingServer, CanNeitherBreakTheBoundsNorMakeAForceOfAnOldAnswer) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  constexpr double kWild[] = {kNan, kInfinite, -kInfinite, 1e300, -1e9, 0.0, 40.0};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    VirtualLoop loop(seed);
    const auto wild = [&] { return kWild[random.Below(static_cast<int>(std::size(kWild)))]; };
    const double most_N = loop.core().limiter().limits().force_N();
    loop.forge = [&](wire::Wrench& answer) {
      switch (random.Below(12)) {
        case 0:
          answer.force_N[random.Below(3)] = wild();
          break;
        case 1:
          answer.torque_Nm[random.Below(3)] = wild();
          break;
        case 2:
          answer.pose_sequence += 1 + random.Below(1'000'000);  // a pose never sent
          break;
        case 3:
          answer.pose_sequence = random.Bits();
          break;
        case 4:
          answer.pose_time_ns += 1'000'000'000;  // a time in the future
          break;
        case 5:
          answer.pose_sequence -= static_cast<std::uint64_t>(random.Below(3));  // twice
          break;
        case 6:
          answer.graphic_position_m[random.Below(3)] = wild();
          answer.graphic_orientation_wxyz[random.Below(4)] = wild();
          break;
        case 7:
          answer.rows = static_cast<std::uint32_t>(random.Bits());
          answer.region_m = answer.region_rad = answer.valid_s = wild();
          for (auto& row : answer.row) row[random.Below(6)] = wild();
          for (double& offset : answer.row_offset_m) offset = wild();
          for (double& force : answer.row_force_N) force = wild();
          break;
        case 8:
          answer.step_time_s = wild();
          answer.contacts = answer.faults = ~0u;
          break;
        default:
          break;
      }
    };
    std::uint64_t newest = 0;
    for (int i = 0; i < 500; ++i) {
      loop.Tick();
      ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, most_N)) << "seed " << seed << ", tick " << i;
      ASSERT_GE(loop.core().newest().pose_sequence, newest);
      ASSERT_LE(loop.core().newest().pose_sequence, loop.core().sequence());
      ASSERT_LE(loop.core().newest().pose_time_ns, loop.now_ns());
      newest = loop.core().newest().pose_sequence;
    }
    EXPECT_GT(loop.core().totals().strays, 0u);
    // The device stops, and so does the force.
    loop.KillServer();
    loop.For(kSilent_ms + 2);
    EXPECT_EQ(loop.applied().force, Vec3::Zero());
    EXPECT_EQ(loop.applied().torque, Vec3::Zero());
  }
}

TEST(UnpluggedDevice, IsAskedForNothingWhileItReportsAFaultAndRampsInWhenItIsBack) {
  VirtualLoop loop(5);
  loop.For(1000);
  loop.device().sample.status |= kDeviceFault;
  for (int i = 0; i < 300; ++i) {
    loop.Tick();
    ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
    ASSERT_LE(loop.applied().force.norm(), loop.before().force.norm());
    if (i >= 51) {
      ASSERT_EQ(loop.applied().force, Vec3::Zero());
    }
  }
  loop.device().sample.status &= ~kDeviceFault;
  int rising = 0;
  while (loop.applied().force.norm() < kForce_N / kRounding && rising < 2000) {
    loop.Tick();
    ASSERT_NO_FATAL_FAILURE(ExpectSafe(loop, kForce_N));
    ++rising;
  }
  EXPECT_GE(rising, 190);
  EXPECT_LT(rising, 500);
}

/// Gives a server's loop poses with made-up sample times.
struct ClockBench {
  std::shared_ptr<const ServedTool> tool = BallTool();
  ServoLoop loop{tool->model};
  Hand hand;
  wire::Wrench answer{};
  std::int64_t time_ns = 1'000'000'000;

  ClockBench() {
    loop.Start(Pose{Vec3(0, 0, kTouch), Quat::Identity()});
    for (int i = 0; i < 500; ++i) Send(1'000'000);
  }
  bool Send(std::int64_t step_ns, const Vec3& p = Vec3(0, 0, kTouch - VirtualLoop::kDepth_m)) {
    wire::HapticPose pose = hand.At(p);
    pose.sample_time_ns = time_ns += step_ns;
    return loop.OnPose(pose, answer);
  }
};

TEST(StationsClock, ThatJumpsBackIsNotHeardUntilTheServerEndsTheSessionForIt) {
  ClockBench bench;
  const std::uint64_t heard = bench.loop.heard();
  EXPECT_FALSE(bench.Send(-500'000'000));
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(bench.Send(1'000'000));
  EXPECT_EQ(bench.loop.heard(), heard) << "the session's patience runs meanwhile";
}

TEST(StationsClock, ThatStandsStillIsNotHeard) {
  ClockBench bench;
  const std::uint64_t heard = bench.loop.heard();
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(bench.Send(0));
  EXPECT_EQ(bench.loop.heard(), heard);
}

TEST(StationsClock, ThatJumpsForwardChangesNoForceOfAHandThatIsStill) {
  ClockBench bench;
  const double force_N = bench.answer.force_N[2];
  EXPECT_NEAR(force_N, kForce_N, 1e-6);
  for (const std::int64_t step_ns : {1'000'000'000ll, 3'600'000'000'000ll, 1'000'000ll}) {
    ASSERT_TRUE(bench.Send(step_ns));
    EXPECT_EQ(bench.answer.force_N[2], force_N);
  }
}

TEST(LyingStation, IsAnsweredWithFiniteForcesOrNotAtAll) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kWild[] = {kNan, std::numeric_limits<double>::infinity(), 1e300, -1e9, 0.0, 2.0};
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    ClockBench bench;
    for (int i = 0; i < 1000; ++i) {
      wire::HapticPose pose = bench.hand.At(Vec3(0, 0, kTouch) + random.InCube(0.05));
      pose.sample_time_ns = bench.time_ns += random.Below(4) * 1'000'000;
      const auto wild = [&] { return kWild[random.Below(static_cast<int>(std::size(kWild)))]; };
      if (random.Below(4) == 0) pose.position_m[random.Below(3)] = wild();
      if (random.Below(4) == 0) pose.orientation_wxyz[random.Below(4)] = wild();
      if (random.Below(4) == 0) pose.linear_velocity_m_s[random.Below(3)] = wild();
      if (random.Below(50) == 0) pose.pose_sequence = random.Bits();
      if (random.Below(50) == 0) pose.sample_time_ns = static_cast<std::int64_t>(random.Bits());
      if (!bench.loop.OnPose(pose, bench.answer)) continue;
      ASSERT_TRUE(wire::ToWrench(bench.answer).force.allFinite());
      ASSERT_TRUE(wire::ToWrench(bench.answer).torque.allFinite());
      const Pose X_WG =
          wire::ToPose(bench.answer.graphic_position_m, bench.answer.graphic_orientation_wxyz);
      ASSERT_TRUE(X_WG.p.allFinite() && X_WG.q.coeffs().allFinite());
    }
  }
}

}  // namespace
}  // namespace palpate::test
