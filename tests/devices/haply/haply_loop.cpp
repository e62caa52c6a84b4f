// Measures, against the fake and in real time, how fast the driver's loop with an Inverse Service
// is, and how soon the force is zero once the service dies.  Prints a table.
#include <algorithm>
#include <cstdio>
#include <vector>

#include <time.h>

#include "tests/devices/haply/haply_bench.h"

namespace palpate::test {
namespace {

constexpr int kTicks = 10'000;
constexpr int kDeaths = 20;

double Percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

void Row(const char* what, const std::vector<double>& values) {
  std::printf("| %s | %.0f | %.0f | %.0f | %.0f |\n", what, Percentile(values, 0.5),
              Percentile(values, 0.99), Percentile(values, 0.999), Percentile(values, 1.0));
}

/// Ticks each millisecond of the absolute clock.
template <class So>
void EachMillisecond(HaplyBench& bench, So go_on) {
  std::int64_t due_ns = SteadyNanoseconds();
  do {
    bench.Tick();
    due_ns = std::max(due_ns + 1'000'000, SteadyNanoseconds());
    const timespec at{due_ns / 1'000'000'000, due_ns % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
  } while (go_on());
}

/// @param realtime  the threads of station, driver and service run with SCHED_FIFO, where granted.
int Main(bool realtime) {
  if (realtime) std::printf("%s\n", EnterRealtime({RealtimeMode::kPrefer}).summary.c_str());
  std::vector<double> trips_us, gone_us, stalled_us;
  {
    FakeInverseService service;
    HaplyBench bench(service);
    if (!bench.UntilForce()) return 1;
    const std::int64_t begun_ns = SteadyNanoseconds();
    const std::uint64_t replies = bench.arm.service().replies;
    std::uint64_t seen = replies;
    int ticks = 0;
    EachMillisecond(bench, [&] {
      const haply::ServiceState& state = bench.arm.service();
      if (state.replies != seen)
        trips_us.push_back(1e-3 * static_cast<double>(state.round_trip_ns));
      seen = state.replies;
      return ++ticks < kTicks;
    });
    const double seconds = 1e-9 * static_cast<double>(SteadyNanoseconds() - begun_ns);
    std::printf("replies a second: %.0f (%d ticks in %.2f s)\n\n",
                static_cast<double>(seen - replies) / seconds, kTicks, seconds);
  }
  for (const bool stall : {false, true}) {
    for (int i = 0; i < kDeaths; ++i) {
      FakeInverseService service;
      HaplyBench bench(service);
      if (!bench.UntilForce()) return 1;
      const std::int64_t died_ns = SteadyNanoseconds();
      if (stall) {
        service.stalls = true;
      } else {
        service.Die();
      }
      EachMillisecond(bench, [&] { return !bench.arm.sent_force().isZero(0.0); });
      (stall ? stalled_us : gone_us)
          .push_back(1e-3 * static_cast<double>(SteadyNanoseconds() - died_ns));
    }
  }
  std::printf("| us | p50 | p99 | p99.9 | most |\n|---|---|---|---|---|\n");
  Row("round trip: command to reply", trips_us);
  Row("force zero after the service dies", gone_us);
  Row("force zero after it stalls", stalled_us);
  return 0;
}

}  // namespace
}  // namespace palpate::test

int main(int count, char** words) {
  return palpate::test::Main(count > 1 && std::string(words[1]) == "--realtime");
}
