#include "client/station/servo_thread.h"

#include <algorithm>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>

#include "tests/station/answered_servo.h"
#include "tests/station/still_device.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

/// Counts ticks: on a busy machine there are fewer a second, and nothing else changes.
struct ServoBench : test::AnsweredServo<test::StillDevice> {
  explicit ServoBench(double rate_Hz = 1000.0) : AnsweredServo(rate_Hz) { core.EnableForces(true); }

  /// Waits for `count` more ticks; false if that takes more than a minute.
  bool Tick(std::uint64_t count) {
    const std::uint64_t end = servo.ticks() + count;
    for (int i = 0; i < 60'000 && servo.ticks() < end; ++i) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    return servo.ticks() >= end;
  }
};

TEST(ServoThread, RestsUntilThereIsAPath) {
  ServoBench bench;
  ServoBench other;  // its ticks tell the time
  other.servo.SetPath(&other.path);
  ASSERT_TRUE(other.Tick(50));
  EXPECT_FALSE(bench.servo.started());
  bench.servo.Stop();
  EXPECT_EQ(bench.core.totals().ticks, 0u);
}

/// A device whose Read takes twenty ticks.
struct SlowDevice : test::StillDevice {
  DeviceSample Read() noexcept override {
    std::this_thread::sleep_for(milliseconds(20));
    return StillDevice::Read();
  }
};

TEST(ServoThread, IsShownInTimeHoweverSlowItsLoopIs) {
  SlowDevice device;
  StationCore core{device};
  ReplyRing replies;
  ServoThread servo{core, replies, 0.1};
  PosePath path;
  servo.SetPath(&path);
  StationSnapshot snapshot;
  int shown = 0;
  while (servo.ticks() < 30) {  // 0.6 s at least
    shown += servo.ReadSnapshot(snapshot);
    std::this_thread::sleep_for(milliseconds(1));
  }
  servo.Stop();
  EXPECT_GE(shown, 2);
  EXPECT_LE(snapshot.rate_hz, 50.0);
  EXPECT_EQ(snapshot.nominal_hz, 1000.0);
}

TEST(ServoThread, ServesTheDeviceWithAPathAndWithoutAndSendsOnlyWithOne) {
  ServoBench bench;
  bench.servo.SetPath(&bench.path);
  ASSERT_TRUE(bench.Tick(20));
  bench.servo.SetPath(nullptr);
  const std::uint64_t ticks_with = bench.servo.ticks();
  ASSERT_TRUE(bench.Tick(20));
  bench.servo.Stop();
  EXPECT_GE(bench.core.totals().sent, 20u);
  EXPECT_LE(bench.core.totals().sent, ticks_with);
  EXPECT_GE(bench.core.totals().ticks, bench.core.totals().sent + 20);
  EXPECT_EQ(bench.device.applications, static_cast<int>(bench.core.totals().ticks));
}

TEST(ServoThread, TicksAtTheDevicesRateAndSendsAThousandPosesASecondAtMost) {
  for (const double rate_Hz : {250.0, 1000.0, 2000.0, 4000.0}) {
    ServoBench bench(rate_Hz);
    bench.servo.SetPath(&bench.path);
    ASSERT_TRUE(bench.Tick(200));
    bench.servo.Stop();
    const auto ticks = static_cast<double>(bench.core.totals().ticks);
    const std::uint64_t sent = bench.core.totals().sent;
    const double ticks_per_pose = std::max(1.0, rate_Hz / 1000.0);
    EXPECT_NEAR(ticks, ticks_per_pose * static_cast<double>(sent), ticks_per_pose);
    // Each tick is due one period after the one before; missed ones are counted.  A tick comes
    // within its period, so both bounds may be off by one.
    const std::uint64_t first = sent > 150 ? sent - 150 : 1;  // whose times are still known
    const double took_s = 1e-9 * static_cast<double>(bench.servo.sample_time_ns(sent) -
                                                     bench.servo.sample_time_ns(first));
    const double between = ticks_per_pose * static_cast<double>(sent - first);
    const auto missed = static_cast<double>(bench.servo.missed_ticks());
    EXPECT_GE(took_s * rate_Hz, between - 1.0) << rate_Hz;
    EXPECT_LE(took_s * rate_Hz, between + missed + 1.0) << rate_Hz;
  }
}

TEST(ServoThread, KnowsWhenItSampledTheLatestPosesAndNoOthers) {
  ServoBench bench;
  EXPECT_EQ(bench.servo.sample_time_ns(0), 0);
  const std::int64_t begin_ns = SteadyNanoseconds();
  bench.servo.SetPath(&bench.path);
  ASSERT_TRUE(bench.Tick(50));
  bench.servo.Stop();
  const std::uint64_t sent = bench.core.totals().sent;
  ASSERT_GE(sent, 50u);
  std::int64_t last_ns = begin_ns;
  for (std::uint64_t sequence = sent - 49; sequence <= sent; ++sequence) {
    EXPECT_GT(bench.servo.sample_time_ns(sequence), last_ns);
    last_ns = bench.servo.sample_time_ns(sequence);
  }
  EXPECT_LT(last_ns, SteadyNanoseconds());
  EXPECT_EQ(bench.servo.sample_time_ns(sent + 1), 0);
}

TEST(ServoThread, BeginsItsTotalsAnewWhenItIsAskedAndItsPosesNumbersGoOn) {
  ServoBench bench;
  bench.servo.SetPath(&bench.path);
  ASSERT_TRUE(bench.Tick(50));
  bench.servo.RestartTotals();
  ASSERT_TRUE(bench.Tick(50));
  bench.servo.BeginToStop();
  bench.servo.Stop();
  const std::uint64_t since = bench.core.totals().sent;
  EXPECT_GE(since, 49u) << "one tick may have begun before";
  EXPECT_GE(bench.core.sequence(), since + 50);
}

TEST(ServoThread, TakesTheForceOutOfTheDeviceBeforeItEnds) {
  ServoBench bench;
  bench.servo.SetPath(&bench.path);
  ASSERT_TRUE(bench.AnswerUntil([&] { return bench.snapshot.force_N >= 1.0; }));
  bench.servo.Stop();
  EXPECT_FALSE(bench.core.renders_force());
  EXPECT_EQ(bench.device.applied.force, Vec3::Zero());
}

TEST(ServoThread, TakesTheForceOutAtASignalThoughItsOwnerHangs) {
  StopSignal stop;
  ServoBench bench;
  bench.servo.LoseForceBy(stop);
  bench.servo.SetPath(&bench.path);
  ASSERT_TRUE(bench.AnswerUntil([&] { return bench.snapshot.force_N >= 1.0; }));
  std::raise(SIGTERM);
  EXPECT_TRUE(bench.AnswerUntil([&] { return bench.servo.done(); }));
  EXPECT_EQ(bench.device.applied.force, Vec3::Zero());
}

}  // namespace
}  // namespace palpate
