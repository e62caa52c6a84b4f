#include "client/station/station_core.h"

#include <deque>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "common/step_fault.h"
#include "devices/workspace.h"
#include "tests/station/still_device.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/milliseconds.h"

namespace palpate {
namespace {

/// A core with a device and its own clock; each tick, the server answers or does not.
struct Bench {
  explicit Bench(const std::optional<Workspace>& workspace = {})
      : Bench(std::make_unique<test::StillDevice>(), workspace) {}
  Bench(std::unique_ptr<test::StillDevice> still, const std::optional<Workspace>& workspace)
      : device(*still),
        driven(workspace ? std::make_unique<WorkspaceDevice>(std::move(still), *workspace)
                         : std::unique_ptr<Device>(std::move(still))) {
    core.EnableForces(true);
  }

  test::StillDevice& device;
  std::unique_ptr<Device> driven;  // `device`, or a workspace around it
  StationCore core{*driven};
  std::int64_t now = 1'000'000 * kMs;
  Wrench wrench{Vec3(0, 0, 2.0), Vec3::Zero()};

  /// One tick.  The reply to its pose arrives `delay` later, before the next tick ends.
  void Tick(bool answered, std::int64_t delay = kMs / 20) {
    now += kMs;
    const OutgoingPose pose = core.Sense(now, true);
    if (answered) core.Take(ReplyTo(pose, delay));
    core.Act(now);
  }
  Reply ReplyTo(const OutgoingPose& pose, std::int64_t delay) const {
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = pose.sample_time_ns;
    reply.received_ns = pose.sample_time_ns + delay;
    reply.wrench = wrench;
    reply.step_time_s = 3e-6;
    reply.contacts = 1;
    return reply;
  }
  double force() const { return device.applied.force.z(); }
};

TEST(StationCore, RendersTheServersForceOnceItHasRampedIn) {
  Bench bench;
  bench.Tick(true);
  EXPECT_LT(bench.force(), 0.1);
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  EXPECT_EQ(bench.force(), 2.0);
}

TEST(StationCore, CountsHowOftenTheDeviceFallsIntoAFault) {
  Bench bench;
  const auto run = [&](std::uint32_t status, int ticks) {
    bench.device.sample.status = status;
    for (int i = 0; i < ticks; ++i) bench.Tick(true);
  };
  run(kDeviceFault, 100);  // an arm is at fault until it is ready
  EXPECT_EQ(bench.core.totals().device_faults, 0u);
  run(kDeviceOk, 100);
  run(kDeviceFault, 50);
  run(kDeviceOk, 100);
  run(kDeviceFault | kDeviceCalibrating, 50);
  EXPECT_EQ(bench.core.totals().device_faults, 2u);
  EXPECT_EQ(bench.core.totals().device_fault_ticks, 200u);
  EXPECT_TRUE(bench.core.TakeSnapshot(bench.now).device_at_fault);
  run(kDeviceOk, 1);
  EXPECT_FALSE(bench.core.TakeSnapshot(bench.now).device_at_fault);
}

TEST(StationCore, RendersPassiveEffectsInFullAndOthersAsAGuide) {
  wire::Wrench sample{};
  sample.force_N[2] = 2.0 + 1.5 + 3.0;
  sample.passive_force_N[2] = 1.5;
  sample.active_force_N[2] = 3.0;
  Bench bench;
  for (int i = 0; i < 800; ++i) {
    bench.now += kMs;
    const OutgoingPose pose = bench.core.Sense(bench.now, true);
    sample.pose_sequence = pose.sequence;
    sample.pose_time_ns = pose.sample_time_ns;
    bench.core.Take(ToReply(sample, bench.now));
    bench.core.Act(bench.now);
  }
  EXPECT_EQ(bench.core.newest().wrench.force.z(), 2.0) << "the contact's";
  EXPECT_NEAR(bench.force(), 2.0 + 1.5 + 1.0, 1e-9);
}

TEST(StationCore, HasNothingLeftOfEffectsWithoutContact) {
  wire::Wrench sample{};
  for (double number = 0.1; number < 3.0; number += 0.1) {
    sample.passive_force_N[0] = number;
    sample.active_force_N[0] = 1.0 / number;
    sample.force_N[0] = 0.0 + (number + 1.0 / number);
    ASSERT_EQ(ToReply(sample, 0).wrench.force.x(), 0.0);
  }
}

TEST(StationCore, SendsWhereTheHandWillBeToAServerThatIsFarAway) {
  for (const bool local_model : {true, false}) {
    Bench bench;
    bench.core.EnableLocalModel(local_model);
    const Vec3 v(0.1, 0, 0);
    OutgoingPose sent;
    std::deque<OutgoingPose> under_way;
    for (int i = 0; i < 1000; ++i) {
      bench.now += kMs;
      bench.device.sample.X_WH.p = 1e-3 * i * v;
      sent = bench.core.Sense(bench.now, true);
      under_way.push_back(sent);
      if (under_way.size() > 10) {
        bench.core.Take(bench.ReplyTo(under_way.front(), 10 * kMs));
        under_way.pop_front();
      }
      bench.core.Act(bench.now);
    }
    EXPECT_EQ(sent.sample.X_WH.p, bench.device.sample.X_WH.p) << "what was read";
    const double led = sent.X_WH.p.x() - sent.sample.X_WH.p.x();
    EXPECT_NEAR(led, local_model ? 0.1 * (0.010 + PoseLead::kHeld_s) : 0.0, 1e-8);
    EXPECT_EQ(bench.core.totals().strays, 0u);
  }
}

TEST(StationCore, ShowsTheDeviceTheGraphicToolOfItsSessionAlone) {
  Bench bench;
  bench.Tick(false);
  EXPECT_FALSE(bench.device.sees_graphic_tool);
  bench.Tick(true);
  EXPECT_TRUE(bench.device.sees_graphic_tool);
  bench.core.Sense(bench.now, false);  // a tick between two poses, of a device faster than 1 kHz
  bench.core.Act(bench.now);
  EXPECT_TRUE(bench.device.sees_graphic_tool);
  bench.core.LoseSession();
  bench.core.Sense(bench.now, false);
  bench.core.Act(bench.now);
  EXPECT_FALSE(bench.device.sees_graphic_tool);
  bench.Tick(false);
  EXPECT_FALSE(bench.device.sees_graphic_tool) << "the next one has not answered";
  bench.Tick(true);
  EXPECT_TRUE(bench.device.sees_graphic_tool);
}

TEST(StationCore, LetsAGuidePullBesideTheServersForceWithinItsLimit) {
  Bench bench;
  bench.core.AcceptGuide(GuideLimits::OfForce(0.5));
  bench.device.sample.V_WH.v = Vec3(0.1, 0, 0);  // it moves along
  for (int i = 0; i < 1000; ++i) {
    bench.core.Take(bench.now, {1, {Vec3(0.010, 0, 0), Quat::Identity()}});
    bench.Tick(true);
    EXPECT_LE(bench.device.applied.force.x(), 0.5 + 1e-12);
  }
  EXPECT_EQ(bench.force(), 2.0);
  EXPECT_NEAR(bench.device.applied.force.x(), 0.5, 1e-12);
  for (int i = 0; i < 100; ++i) bench.Tick(true);
  EXPECT_EQ(bench.device.applied.force.x(), 0.0) << "the guide is silent";
  EXPECT_EQ(bench.force(), 2.0);
}

TEST(StationCore, DrivesNothingByAGuideAloneOrUnasked) {
  for (const bool accepts : {true, false}) {
    Bench bench;
    if (accepts) bench.core.AcceptGuide(GuideLimits::OfForce(0.5));
    bench.wrench = Wrench{};
    for (int i = 0; i < 1000; ++i) {
      bench.core.Take(bench.now, {1, {Vec3(0.004, 0, 0), Quat::Identity()}});
      bench.Tick(!accepts);  // the one that accepts has no server
      EXPECT_EQ(bench.device.applied.force.norm(), 0.0);
    }
  }
}

TEST(StationCore, KeepsForcesOffUntilTheyAreEnabled) {
  Bench bench;
  bench.core.EnableForces(false);
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_FALSE(bench.core.Sense(bench.now, false).sample.status & kDeviceForcesEnabled);
  bench.core.EnableForces(true);
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  EXPECT_EQ(bench.force(), 2.0);
  EXPECT_TRUE(bench.core.Sense(bench.now, false).sample.status & kDeviceForcesEnabled);
}

TEST(StationCore, RampsToZeroWhileItIsMutedWhoeverWantsForces) {
  Bench bench;
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  ASSERT_EQ(bench.force(), 2.0);
  bench.core.Mute(true);
  double last = bench.force();
  for (int i = 0; i < 400; ++i) {
    bench.core.EnableForces(true);
    bench.Tick(true);
    EXPECT_LE(bench.force(), last);
    EXPECT_GE(bench.force(), last - 0.16) << "smooth";
    last = bench.force();
  }
  EXPECT_EQ(last, 0.0);
  bench.core.Mute(false);
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  EXPECT_EQ(bench.force(), 2.0);
}

TEST(StationCore, FadesToZeroWithinTwentyFiveMillisecondsOfTheServersDeath) {
  Bench bench;
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  double last = bench.force();
  for (int ms = 1; ms <= 100; ++ms) {
    bench.Tick(false);
    EXPECT_LE(bench.force(), last);
    EXPECT_GE(bench.force(), last - 0.16);  // smooth: the steepest part of the fade, 7.1 % a ms
    if (ms <= 3) {
      EXPECT_EQ(bench.force(), 2.0) << ms;
    }
    // The last reply came 0.05 ms after its tick.
    if (ms >= 26) {
      EXPECT_EQ(bench.force(), 0.0) << ms;
    }
    last = bench.force();
  }
  EXPECT_EQ(bench.core.limiter().counts().fades, 1u);
  EXPECT_EQ(bench.device.applications, 500);  // the device is driven all the time
}

TEST(StationCore, AgesAReplyFromThePoseThatItAnswers) {
  Bench bench;
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  // The server answers each tick, but a pose of a fifth of a second ago: as good as dead.
  std::vector<OutgoingPose> poses;
  for (int i = 0; i < 1100; ++i) {
    bench.now += kMs;
    poses.push_back(bench.core.Sense(bench.now, true));
    if (i >= 200) bench.core.Take(bench.ReplyTo(poses[i - 200], 200 * kMs));
    bench.core.Act(bench.now);
  }
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_EQ(bench.core.totals().late, 900u);
}

TEST(StationCore, IgnoresRepliesThatItCannotHaveAskedFor) {
  Bench bench;
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  Reply evil;
  evil.wrench.force = Vec3(100, 0, 0);
  evil.pose_time_ns = bench.now;
  evil.pose_sequence = 1'000'000;  // of no pose that was sent
  bench.core.Take(evil);
  evil.pose_sequence = 400;  // answered already
  bench.core.Take(evil);
  evil.pose_sequence = 399;  // out of order
  bench.core.Take(evil);
  const OutgoingPose pose = bench.core.Sense(bench.now + kMs, true);
  evil.pose_sequence = pose.sequence;
  evil.pose_time_ns = bench.now + 2000 * kMs;  // from the future: it would never age
  bench.core.Take(evil);
  evil.pose_time_ns = std::numeric_limits<std::int64_t>::min();
  bench.core.Take(evil);
  EXPECT_EQ(bench.core.totals().strays, 5u);
  bench.core.Act(bench.now + kMs);
  EXPECT_EQ(bench.device.applied.force, Vec3(0, 0, 2.0));
}

TEST(StationCore, NumbersOnlyThePosesThatItSends) {
  Bench bench;
  EXPECT_EQ(bench.core.Sense(bench.now, true).sequence, 1u);
  EXPECT_EQ(bench.core.Sense(bench.now, false).sequence, 1u);
  EXPECT_EQ(bench.core.Sense(bench.now, true).sequence, 2u);
  EXPECT_EQ(bench.core.totals().sent, 2u);
}

TEST(StationCore, ShiftsTheWrenchFromTheToolsCentroidToTheHandle) {
  Bench bench;
  bench.device.sample.X_WH.q = RotationExp(Vec3(0, 0, M_PI / 2));  // x of the tool is y of W
  bench.core.SetSpring({1000.0, 1.0, Vec3(0.1, 0, 0)});
  bench.wrench = {Vec3(0, 0, 2.0), Vec3(0.01, 0, 0)};
  for (int i = 0; i < 400; ++i) bench.Tick(true);
  EXPECT_EQ(bench.device.applied.force, Vec3(0, 0, 2.0));
  // c = 0.1 y; c x F = 0.2 N m about x.
  EXPECT_NEAR((bench.device.applied.torque - Vec3(0.21, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(StationCore, CountsWhatWasLateLostAndInContact) {
  Bench bench;
  for (int i = 0; i < 10; ++i) bench.Tick(true);
  for (int i = 0; i < 3; ++i) bench.Tick(true, 3 * kMs / 2);
  for (int i = 0; i < 4; ++i) bench.Tick(false);
  EXPECT_EQ(bench.core.lost(), 0u);  // they may still come
  bench.Tick(true);
  const StationTotals& totals = bench.core.totals();
  EXPECT_EQ(totals.sent, 18u);
  EXPECT_EQ(totals.replies, 14u);
  EXPECT_EQ(totals.late, 3u);
  EXPECT_EQ(bench.core.lost(), 4u);
  EXPECT_EQ(totals.contact_replies, 14u);
  EXPECT_EQ(totals.round_trip.count(), 14u);
  EXPECT_EQ(totals.round_trip.max(), 1'500'000u);
}

TEST(StationCore, ForgetsWhatCameBeforeItsTotalsBeganAnew) {
  Bench bench;
  bench.Tick(true);
  bench.Tick(false);
  for (int i = 0; i < 10; ++i) bench.Tick(true, 2 * kMs);
  bench.core.RestartTotals();
  for (int i = 0; i < 5; ++i) bench.Tick(i != 2);
  EXPECT_EQ(bench.core.totals().ticks, 5u);
  EXPECT_EQ(bench.core.totals().sent, 5u);
  EXPECT_EQ(bench.core.totals().replies, 4u);
  EXPECT_EQ(bench.core.totals().late, 0u);
  EXPECT_EQ(bench.core.totals().round_trip.count(), 4u);
  EXPECT_EQ(bench.core.lost(), 1u);
}

TEST(StationCore, RemembersFaultsButForTheOneThatEverySessionBeginsWith) {
  Bench bench;
  Reply reply = bench.ReplyTo(bench.core.Sense(bench.now, true), kMs / 20);
  reply.faults = kFaultNotStarted | kFaultJammed;
  bench.core.Take(reply);
  EXPECT_EQ(bench.core.TakeSnapshot(bench.now).faults, kFaultNotStarted | kFaultJammed);
  EXPECT_EQ(bench.core.totals().faults, kFaultJammed);
}

TEST(StationCore, ShowsAPeriodAndThenBeginsANewOne) {
  Bench bench;
  bench.core.TakeSnapshot(bench.now);
  for (int i = 0; i < 250; ++i) bench.Tick(true);
  const StationSnapshot snapshot = bench.core.TakeSnapshot(bench.now);
  EXPECT_NEAR(snapshot.rate_hz, 1000.0, 1e-6);
  EXPECT_NEAR(snapshot.round_trip_us_p50, 50.0, 50.0 / 32);
  EXPECT_NEAR(snapshot.server_step_us_p50, 3.0, 3.0 / 32);
  EXPECT_EQ(snapshot.replies, 250u);
  EXPECT_EQ(snapshot.contacts, 1u);
  EXPECT_GT(snapshot.force_N, 1.9);
  const StationSnapshot next = bench.core.TakeSnapshot(bench.now + kMs);
  EXPECT_EQ(next.replies, 0u);
  EXPECT_EQ(next.round_trip_us_p50, 0.0);
  EXPECT_EQ(next.peak_force_N, 0.0);
}

TEST(StationCore, AllocatesNothing) {
  Bench bench;
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 500; ++i) bench.Tick(i % 3 != 0);
  bench.core.TakeSnapshot(bench.now);
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

/// A workspace with walls, 0.2 m from its centre.
Workspace WithWalls() {
  Workspace workspace;
  workspace.wall_force_N = 3.0;
  return workspace;
}

TEST(StationCore, HasNoWallsUntilForcesAreEnabledAndRampsThemIn) {
  Bench bench(WithWalls());
  bench.core.EnableForces(false);
  bench.wrench = {};
  bench.device.sample.X_WH.p.x() = 0.2;  // the end of its reach
  for (int i = 0; i < 500; ++i) bench.Tick(true);
  EXPECT_EQ(bench.device.applied.force, Vec3::Zero());
  bench.core.EnableForces(true);
  for (int i = 0; i < 500; ++i) {
    const Vec3 before = bench.device.applied.force;
    bench.Tick(true);
    EXPECT_LE((bench.device.applied.force - before).norm(), 3.0 / 200.0 + 1e-9);
  }
  EXPECT_NEAR(bench.device.applied.force.x(), -3.0, 1e-9);
}

TEST(StationCore, BoundsWallsAndContactTogether) {
  Bench bench(WithWalls());
  bench.wrench.force = Vec3(-100, 0, 0);
  bench.device.sample.X_WH.p.x() = 0.2;
  for (int i = 0; i < 300; ++i) bench.Tick(true);
  EXPECT_NEAR(bench.device.applied.force.norm(), 22.0, 1e-9);
}

}  // namespace
}  // namespace palpate
