#include "client/station/servo_thread.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "common/time/steady_clock.h"
#include "tests/station/still_device.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

/// A thread whose poses go nowhere, and a test that plays the server.
struct Bench {
  explicit Bench(double rate_Hz = 1000.0) : device(rate_Hz) { core.EnableForces(true); }

  test::StillDevice device;
  StationCore core{device};
  ReplyRing replies;
  ServoThread servo{core, replies, 0.002};  // each snapshot allows one fresh reply
  PosePath path;
  StationSnapshot snapshot;

  /// Answers poses with 2 N for that time.
  void Answer(milliseconds time) {
    const std::int64_t end = SteadyNanoseconds() + std::chrono::nanoseconds(time).count();
    while (SteadyNanoseconds() < end) {
      while (servo.ReadSnapshot(snapshot)) {
      }
      Reply reply;
      reply.pose_sequence = snapshot.sent;
      reply.pose_time_ns = servo.sample_time_ns(reply.pose_sequence);
      reply.received_ns = SteadyNanoseconds();
      reply.wrench.force = Vec3(0, 0, 2.0);
      replies.Push(reply);
      std::this_thread::sleep_for(milliseconds(1));
    }
  }
};

TEST(ServoThread, RestsUntilThereIsAPath) {
  Bench bench;
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_FALSE(bench.servo.started());
  bench.servo.Stop();
  EXPECT_EQ(bench.core.totals().ticks, 0u);
}

TEST(ServoThread, ServesTheDeviceWithAPathAndWithout) {
  Bench bench;
  bench.servo.SetPath(&bench.path);
  std::this_thread::sleep_for(milliseconds(50));
  bench.servo.SetPath(nullptr);
  std::this_thread::sleep_for(milliseconds(50));
  bench.servo.Stop();
  EXPECT_GT(bench.core.totals().sent, 0u);
  EXPECT_GT(bench.core.totals().ticks, bench.core.totals().sent);
}

TEST(ServoThread, TicksAtTheDevicesRateAndSendsAThousandPosesASecondAtMost) {
  for (const double rate_Hz : {250.0, 1000.0, 2000.0, 4000.0}) {
    Bench bench(rate_Hz);
    bench.servo.SetPath(&bench.path);
    const auto ticks = [&] { return bench.servo.ticks(); };
    while (ticks() < 100) std::this_thread::sleep_for(milliseconds(1));
    bench.servo.Stop();
    const double ticks_per_pose = std::max(1.0, rate_Hz / 1000.0);
    EXPECT_NEAR(static_cast<double>(bench.core.totals().ticks),
                ticks_per_pose * static_cast<double>(bench.core.totals().sent), ticks_per_pose);
  }
}

TEST(ServoThread, EnablesNothingByAButtonThatHasNotBeenSeenUp) {
  Bench bench;
  bench.core.EnableForces(false);
  bench.servo.EnableForcesByButton();
  bench.device.sample.buttons = 1;
  bench.servo.SetPath(&bench.path);
  for (int i = 0; i < 5; ++i) bench.Answer(milliseconds(100));
  bench.servo.Stop();
  EXPECT_GT(bench.core.totals().replies, 0u);
  EXPECT_EQ(bench.core.totals().max_force_N, 0.0);
}

TEST(ServoThread, KnowsWhenItSampledTheLatestPosesAndNoOthers) {
  Bench bench;
  EXPECT_EQ(bench.servo.sample_time_ns(0), 0);
  const std::int64_t begin_ns = SteadyNanoseconds();
  bench.servo.SetPath(&bench.path);
  std::this_thread::sleep_for(milliseconds(50));
  bench.servo.Stop();
  const std::uint64_t sent = bench.core.totals().sent;
  ASSERT_GT(sent, 1u);
  std::int64_t last_ns = begin_ns;
  for (std::uint64_t sequence = 1; sequence <= sent; ++sequence) {
    EXPECT_GT(bench.servo.sample_time_ns(sequence), last_ns);
    last_ns = bench.servo.sample_time_ns(sequence);
  }
  EXPECT_LT(last_ns, SteadyNanoseconds());
  EXPECT_EQ(bench.servo.sample_time_ns(sent + 1), 0);
}

TEST(ServoThread, BeginsItsTotalsAnewWhenItIsAsked) {
  Bench bench;
  bench.servo.SetPath(&bench.path);
  std::this_thread::sleep_for(milliseconds(50));
  while (!bench.servo.ReadSnapshot(bench.snapshot)) {
  }
  const std::uint64_t before = bench.snapshot.sent;
  bench.servo.RestartTotals();
  for (int i = 0; i < 2000 && bench.snapshot.sent >= before; ++i) {
    std::this_thread::sleep_for(milliseconds(1));
    bench.servo.ReadSnapshot(bench.snapshot);
  }
  EXPECT_LT(bench.snapshot.sent, before);
  bench.servo.BeginToStop();
  bench.servo.Stop();
  // The poses' numbers go on.
  EXPECT_GT(bench.core.Sense(SteadyNanoseconds(), false).sequence, before);
}

TEST(ServoThread, TakesTheForceOutOfTheDeviceBeforeItEnds) {
  Bench bench;
  bench.servo.SetPath(&bench.path);
  for (int i = 0; i < 300 && bench.snapshot.force_N < 1.0; ++i) bench.Answer(milliseconds(100));
  ASSERT_GE(bench.snapshot.force_N, 1.0);
  bench.servo.Stop();
  EXPECT_FALSE(bench.core.renders_force());
  EXPECT_EQ(bench.device.applied.force, Vec3::Zero());
}

}  // namespace
}  // namespace palpate
