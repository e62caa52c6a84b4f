// A trace on its way from the loop's thread through the file to the figures.
#include <cmath>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <unistd.h>

#include "client/station/trace.h"
#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/link/silence.h"
#include "tests/support/complaint.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

struct TraceTest : testing::Test {
  const std::string file = testing::TempDir() + "palpate_trace_" + std::to_string(getpid());
  ~TraceTest() override { std::filesystem::remove(file); }
};

TickRecord Tick(std::uint64_t tick) {
  TickRecord record;
  record.limiter.calls = tick;
  record.time_ns = 1'000'000 * static_cast<std::int64_t>(tick);
  record.pose_sequence = tick;
  return record;
}

TEST_F(TraceTest, HoldsWhatItWasGiven) {
  TickRecord first = Tick(1);
  TickRecord second = Tick(2);
  second.reply_sequence = 1;
  second.reply_pose_time_ns = first.time_ns;
  second.reply_received_ns = first.time_ns + 250'000;
  second.wanted = {Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3)};
  second.applied = {Vec3(-1, -2, -3), Vec3(-0.1, -0.2, 1e-9 / 3)};
  second.limiter.slewed = second.limiter.faded = 1;
  Trace trace(file);
  trace.Add(first);
  trace.Add(second);
  trace.Close();
  EXPECT_EQ(trace.dropped(), 0u);

  const std::vector<TraceRow> rows = ReadTrace(file);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].reply, 0u);
  EXPECT_TRUE(std::isinf(rows[0].age_ms) && std::isinf(rows[0].silence_ms));
  EXPECT_EQ(rows[0].limiter, "");
  EXPECT_EQ(rows[1].time_ns, 2'000'000);
  EXPECT_EQ(rows[1].tick, 2u);
  EXPECT_EQ(rows[1].pose, 2u);
  EXPECT_EQ(rows[1].reply, 1u);
  EXPECT_DOUBLE_EQ(rows[1].age_ms, 1.0);
  EXPECT_DOUBLE_EQ(rows[1].silence_ms, 0.75);
  EXPECT_TRUE(rows[1].wanted.force.isApprox(second.wanted.force, 1e-8));
  EXPECT_TRUE(rows[1].wanted.torque.isApprox(second.wanted.torque, 1e-8));
  EXPECT_TRUE(rows[1].applied.force.isApprox(second.applied.force, 1e-8));
  EXPECT_TRUE(rows[1].applied.torque.isApprox(second.applied.torque, 1e-8));
  EXPECT_EQ(rows[1].limiter, "slew+age");
  EXPECT_TRUE(rows[1].Limited("slew") && rows[1].Limited("age"));
  EXPECT_FALSE(rows[1].Limited("enable"));
}

TEST_F(TraceTest, CountsWhatFindsNoRoomAndKeepsTheRestInOrder) {
  constexpr std::uint64_t kTicks = 400'000;
  std::uint64_t dropped = 0;
  {
    Trace trace(file);
    std::thread loop([&] {
      for (std::uint64_t tick = 1; tick <= kTicks; ++tick) trace.Add(Tick(tick));
    });
    loop.join();
    trace.Close();
    dropped = trace.dropped();
  }
  const std::vector<TraceRow> rows = ReadTrace(file);
  EXPECT_EQ(rows.size() + dropped, kTicks);
  EXPECT_GT(dropped, 0u) << "no disk takes a row in a few nanoseconds";
  std::uint64_t gaps = kTicks - rows.back().tick, last = 0;
  for (const TraceRow& row : rows) {
    ASSERT_GT(row.tick, last);
    gaps += row.tick - last - 1;
    last = row.tick;
  }
  EXPECT_EQ(gaps, dropped);
}

TEST_F(TraceTest, NamesTheOptionWhereTheFileCannotBeMade) {
  EXPECT_THAT(ComplaintOf([] { Trace trace("/no/such/folder/trace.csv"); }),
              HasSubstr("--trace /no/such/folder/trace.csv: cannot be written"));
}

/// A force of 1 N whose replies stop after tick 100 and return with tick 200: it fades from tick
/// 105 to 125.
std::vector<TraceRow> Fade() {
  std::vector<TraceRow> rows;
  for (std::uint64_t tick = 1; tick <= 400; ++tick) {
    TraceRow row;
    row.time_ns = 1'000'000 * static_cast<std::int64_t>(tick);
    row.tick = row.pose = tick;
    row.reply = tick <= 100 ? tick : tick < 200 ? 100 : tick;
    row.silence_ms = static_cast<double>(tick - row.reply);
    row.wanted.force = Vec3(0, 0, 1);
    const double t = static_cast<double>(tick);
    const double gain = tick < 200 ? std::clamp((125.0 - t) / 20.0, 0.0, 1.0)
                                   : std::clamp((t - 200.0) / 100.0, 0.0, 1.0);
    row.applied.force = gain * row.wanted.force;
    rows.push_back(row);
  }
  return rows;
}

TEST(MeasureSilence, FindsTheTimesAndTheSteepestStepOfAFade) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  const Silence silence = MeasureSilence(Fade(), 90'000'000, limits);
  EXPECT_DOUBLE_EQ(silence.share_before, 1.0);
  EXPECT_TRUE(silence.stayed_zero);
  EXPECT_NEAR(silence.largest_step, 0.05 / limits.force_slew_N_per_ms(), 1e-12);
  EXPECT_DOUBLE_EQ(silence.until_back_ms, 99.0);  // except for a hundredth
}

/// The machine stalls for 100 ms in the middle of a fade; the ticks after it are on time.
std::vector<TraceRow> FadeHeldUp() {
  std::vector<TraceRow> rows = Fade();
  for (TraceRow& row : rows) {
    if (row.tick > 110) row.time_ns += 100'000'000;
    if (row.tick > 110 && row.tick < 200) row.silence_ms += 100.0;
  }
  return rows;
}

TEST(MeasureSilence, CountsTwoMillisecondsForATickThatTheMachineHeldUp) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  EXPECT_DOUBLE_EQ(MeasureSilence(Fade(), 90'000'000, limits).counted_until_zero_ms, 25.0);
  EXPECT_DOUBLE_EQ(MeasureSilence(FadeHeldUp(), 90'000'000, limits).counted_until_zero_ms, 26.0);
}

TEST(MeasureSilence, SeesAForceThatComesBackWithoutAReply) {
  std::vector<TraceRow> rows = Fade();
  rows[150].applied.force.z() = 0.01;
  EXPECT_FALSE(
      MeasureSilence(rows, 90'000'000, WrenchLimits::Of(PhantomPremium30().info)).stayed_zero);
}

TEST(MeasureSilence, SaysWhereThereIsNone) {
  EXPECT_THROW(MeasureSilence(Fade(), 300'000'000, WrenchLimits::Of(PhantomPremium30().info)),
               Error);
}

}  // namespace
}  // namespace palpate::test
