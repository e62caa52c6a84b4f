// The station's servo thread in the arm's own: real threads, so that ThreadSanitizer has something
// to see.  What counts here is order, not time.
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "client/station/servo_thread.h"
#include "common/realtime/steady_clock.h"
#include "tests/devices/openhaptics/hd_bench.h"
#include "tests/support/eventually.h"

namespace palpate::test {
namespace {

using std::chrono::milliseconds;

class OpenHapticsRealtime : public ArmTest {
 protected:
  void SetUp() override {
    FakeHdSetup setup;
    setup.real_time = true;
    fake.Reset(setup);
  }
};

/// What RunStation does, with a server that always answers 2 N.
struct LiveStation {
  explicit LiveStation(const DeviceOptions& options) : arm(options) {}

  void Poll() {
    arm.Attend();
    while (servo.ReadSnapshot(snapshot)) {
    }
    Reply reply;
    reply.pose_sequence = snapshot.sent;
    reply.pose_time_ns = servo.sample_time_ns(reply.pose_sequence);
    reply.received_ns = SteadyNanoseconds();
    reply.wrench.force = Vec3(0.0, 2.0, 0.0);
    replies.Push(reply);
  }
  bool Until(const std::function<bool()>& so) {
    return Eventually([&] {
      Poll();
      return so();
    });
  }

  OpenHapticsDevice arm;
  StationCore core{arm};
  ReplyRing replies;
  ServoThread servo{core, replies, 0.002};
  PosePath path;
  StationSnapshot snapshot;
};

TEST_F(OpenHapticsRealtime, TicksInTheArmsThreadAndSendsAtMostAThousandPosesASecond) {
  DeviceOptions options = Options();
  options.rate_Hz = 4000.0;
  LiveStation station(options);
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.Until([&] { return station.snapshot.sent >= 100; }));
  station.servo.Stop();
  const StationTotals& totals = station.core.totals();
  EXPECT_NEAR(static_cast<double>(totals.ticks), 4.0 * static_cast<double>(totals.sent), 4.0);
}

TEST_F(OpenHapticsRealtime, RendersTheForceAndTakesItOutBeforeItStops) {
  LiveStation station(Options());
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.Until([&] { return fake.MotorForce() > 0.2; }));
  station.servo.SetPath(nullptr);  // while the arm ticks
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.Until([&] { return fake.MotorForce() > 0.2; }));
  station.servo.Stop();
  EXPECT_FALSE(fake.running());
  EXPECT_FALSE(station.core.renders_force());
  EXPECT_FALSE(fake.Frames().back().force_set && fake.Frames().back().force_N[1] > 0.0);
}

TEST_F(OpenHapticsRealtime, NeedsTheButtonHeldForForcesAndNotOneThatIsStuck) {
  LiveStation station(Options());
  station.servo.EnableForcesByButton();
  fake.arm->buttons = 1;
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.Until([&] { return station.arm.State().output == OutputGate::State::kOn; }));
  const std::uint64_t ticks = fake.arm->ticks;
  ASSERT_TRUE(station.Until([&] { return fake.arm->ticks > ticks + 300; }));
  EXPECT_EQ(fake.arm->most_force_N, 0.0) << "it has been down since the start";
  fake.arm->buttons = 0;
  ASSERT_TRUE(station.Until([&] { return station.arm.State().buttons == 0; }));
  fake.arm->buttons = 1;
  ASSERT_TRUE(station.Until([&] { return fake.MotorForce() > 0.2; }));
  fake.arm->buttons = 0;
  ASSERT_TRUE(station.Until([&] { return fake.MotorForce() == 0.0; }));
}

TEST_F(OpenHapticsRealtime, EndsWhereTheArmsSchedulerHasDied) {
  LiveStation station(Options());
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.Until([&] { return fake.MotorForce() > 0.2; }));
  fake.Die();
  ASSERT_TRUE(Eventually([&] { return fake.MotorForce() == 0.0; }));
  station.servo.SetPath(nullptr);
  station.servo.Stop();
  EXPECT_FALSE(fake.running());
}

TEST_F(OpenHapticsRealtime, LeavesNoForceBehindWhenTheStationsTickHangsNorWhenItComesBack) {
  std::atomic<bool> hang{false};
  std::atomic<bool> hung{false};
  OpenHapticsDevice arm(Options());
  StationCore core(arm);
  core.EnableForces(true);
  arm.StartTicks([&] {
    const std::int64_t now_ns = SteadyNanoseconds();
    const OutgoingPose pose = core.Sense(now_ns, true);
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = reply.received_ns = now_ns;
    reply.wrench.force = Vec3(0.0, 2.0, 0.0);
    core.Take(reply);
    if (hang) {
      hung = true;
      std::this_thread::sleep_for(milliseconds(200));
    }
    core.Act(now_ns);
  });
  const auto attend = [&] { return arm.Attend(), true; };
  ASSERT_TRUE(Eventually([&] { return attend() && fake.MotorForce() > 0.2; }));
  hang = true;
  ASSERT_TRUE(Eventually([&] { return hung.load(); }));
  // The frame never ends: the amplifier hears nothing, and its watchdog lets go.
  ASSERT_TRUE(Eventually([&] { return fake.MotorForce() == 0.0; }));
  ASSERT_TRUE(Eventually([&] { return attend() && arm.State().long_ticks > 0; }));
  hang = false;
  arm.StopTicks();
  bool late_force = false;
  std::uint64_t last = 0;
  for (const FakeFrame& frame : fake.Frames()) {
    last = frame.tick;
    late_force = frame.force_set && frame.force_N[1] > 0.0;
  }
  EXPECT_GT(last, 0u);
  EXPECT_FALSE(late_force) << "the frame after the hang sets nothing";
}

}  // namespace
}  // namespace palpate::test
