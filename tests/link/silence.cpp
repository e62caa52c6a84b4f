#include "tests/link/silence.h"

#include <algorithm>
#include <limits>

#include "common/error.h"

namespace palpate::test {
namespace {

constexpr double kDead_ms = 30.0;

bool IsZero(const Wrench& wrench) {
  return wrench.force.isZero(0.0) && wrench.torque.isZero(0.0);
}

}  // namespace

double LargestStep(const std::vector<TraceRow>& rows, std::size_t begin, std::size_t end,
                   const WrenchLimits& limits) {
  double largest = 0.0;
  for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i) {
    if (rows[i].tick != rows[i - 1].tick + 1) continue;  // rows are missing
    const double dt_ms = std::min(1e-6 * static_cast<double>(rows[i].time_ns - rows[i - 1].time_ns),
                                  1e3 * kMaxTick_s);
    largest = std::max({largest,
                        (rows[i].applied.force - rows[i - 1].applied.force).norm() /
                            (limits.force_slew_N_per_ms() * dt_ms),
                        (rows[i].applied.torque - rows[i - 1].applied.torque).norm() /
                            (limits.torque_slew_Nm_per_ms() * dt_ms)});
  }
  return largest;
}

std::vector<double> CountedSilence_ms(const std::vector<TraceRow>& rows) {
  std::vector<double> silence(rows.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].reply == 0) continue;
    silence[i] = 0.0;
    if (i == 0 || rows[i].reply != rows[i - 1].reply) continue;
    // Ticks whose rows were dropped count as well, each for at most that.
    const auto ticks = static_cast<double>(rows[i].tick - rows[i - 1].tick);
    silence[i] =
        silence[i - 1] + std::min(1e-6 * static_cast<double>(rows[i].time_ns - rows[i - 1].time_ns),
                                  ticks * 1e3 * kMaxTick_s);
  }
  return silence;
}

Silence MeasureSilence(const std::vector<TraceRow>& rows, std::int64_t after_ns,
                       const WrenchLimits& limits) {
  const auto index = [&](auto from, auto holds) {
    return static_cast<std::size_t>(
        std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(from), rows.end(), holds) -
        rows.begin());
  };
  const std::size_t dead = index(0, [&](const TraceRow& row) {
    return row.time_ns > after_ns && row.reply > 0 && row.silence_ms > kDead_ms;
  });
  if (dead == rows.size()) throw Error("the trace has no silence after that time");
  const std::uint64_t reply = rows[dead].reply;
  const std::size_t last = index(0, [&](const TraceRow& row) { return row.reply == reply; });
  const std::size_t next = index(dead, [&](const TraceRow& row) { return row.reply != reply; });
  // The share that was applied before: the energy stage withholds part of the lightest touches.
  const auto share = [](const TraceRow& row) {
    const double wanted_N = row.wanted.force.norm();
    return wanted_N > 0.0 ? row.applied.force.norm() / wanted_N : 0.0;
  };
  const double before = share(rows[last]);
  const std::size_t back = index(next, [&](const TraceRow& row) {
    return share(row) >= 0.99 * before && !IsZero(row.applied);
  });
  if (back == rows.size() || IsZero(rows[last].applied)) {
    throw Error("a silence without a force at its begin or its end");
  }
  const std::size_t zero = index(last, [](const TraceRow& row) { return IsZero(row.applied); });
  if (zero == rows.size()) throw Error("the force never ended");

  Silence silence;
  silence.share_before = before;
  silence.counted_until_zero_ms = CountedSilence_ms(rows)[zero];
  silence.stayed_zero =
      index(zero, [](const TraceRow& row) { return !IsZero(row.applied); }) >= next;
  silence.largest_step = LargestStep(rows, last, back, limits);
  silence.until_back_ms = 1e-6 * static_cast<double>(rows[back].time_ns - rows[next].time_ns);
  return silence;
}

}  // namespace palpate::test
