#include "client/doctor/jitter.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <time.h>

#include "common/realtime/steady_clock.h"

namespace palpate::doctor {
namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
// Of a thousand wake-ups a second, p99.9 is what comes once a second.  A pose's way takes some tens
// of microseconds of its millisecond: with half of it lost it still arrives, and a station does not
// age its wrench for a millisecond or two that come now and then.
constexpr double kGood_us = 100.0;
constexpr double kBearable_us = 500.0;
constexpr double kOneTick_us = 1000.0;

timespec ToTimespec(std::int64_t time_ns) {
  return {.tv_sec = time_ns / kSecond_ns, .tv_nsec = time_ns % kSecond_ns};
}

void Loop(std::int64_t end_ns, const std::atomic<bool>& stop, Jitter& jitter) {
  std::int64_t due_ns = SteadyNanoseconds() + kPeriod_ns;
  while (due_ns < end_ns && !stop.load(std::memory_order_relaxed)) {
    const timespec due = ToTimespec(due_ns);
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    const std::int64_t late_ns = SteadyNanoseconds() - due_ns;
    jitter.lateness.Add(late_ns);
    const std::int64_t passed = late_ns / kPeriod_ns;
    jitter.missed += static_cast<std::uint64_t>(passed);
    due_ns += (1 + passed) * kPeriod_ns;
  }
}

}  // namespace

Jitter MeasureJitter(double seconds, const RealtimeOptions& realtime, StopSignal& stop) {
  Jitter jitter;
  std::atomic<bool> end{false};
  std::atomic<bool> done{false};
  std::exception_ptr error;
  std::thread thread([&] {
    try {
      EnterRealtime(realtime);
      Loop(SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds), end, jitter);
    } catch (...) {
      error = std::current_exception();
    }
    done = true;
  });
  while (!done && !stop.WaitFor(std::chrono::milliseconds(50))) {
  }
  end = true;
  thread.join();
  if (error) std::rethrow_exception(error);
  return jitter;
}

Finding CheckJitter(const Jitter& jitter) {
  const auto us = [](std::uint64_t ns) { return 1e-3 * static_cast<double>(ns); };
  const double p999_us = us(jitter.lateness.Quantile(0.999));
  const double max_us = us(jitter.lateness.max());
  std::string found =
      fmt::format("once a second a loop is {:.0f} us late, and at most {:.0f} us", p999_us, max_us);
  if (jitter.missed > 0) found += fmt::format("; {} ms were missed", jitter.missed);
  if (p999_us <= kGood_us && max_us <= kOneTick_us) return Ok(found);
  constexpr const char* kRemedy =
      "mend what stands above, then end other programs ('top' shows who works) and try again; in a "
      "virtual machine, give it cores of its own (pinned), or take a real host";
  return p999_us > kBearable_us ? Fault(found, kRemedy) : Warning(found, kRemedy);
}

}  // namespace palpate::doctor
