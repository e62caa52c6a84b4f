#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "devices/wrench_limiter.h"
#include "tests/link/trace_file.h"

namespace palpate::test {

/// What a hand felt while its server was silent, from the station's trace.  Times are since the
/// reply after the last one was due: a millisecond after that.
struct Silence {
  double force_before_N = 0.0;  ///< applied when the last reply came
  double share_before = 0.0;    ///< of what was wanted, that was applied then
  double until_fall_ms = 0.0;   ///< first tick with less than 0.999 of its share of what was wanted
  double until_zero_ms = 0.0;   ///< first tick without any force or torque
  double counted_until_zero_ms = 0.0;  ///< the same, as CountedSilence has it
  bool stayed_zero = false;            ///< from there to the next reply
  double largest_step = 0.0;   ///< between two ticks, in parts of the slew limit; with the way back
  double until_back_ms = 0.0;  ///< from the next reply until that share is there again
};

/// The first silence of at least 30 ms after that time.  Throws Error where the trace has none with
/// a force at its begin and its end in it.
Silence MeasureSilence(const std::vector<TraceRow>& rows, std::int64_t after_ns,
                       const WrenchLimits& limits);

/// How long no reply had come, at each row, as the limiter counts: from the row that took the last
/// one on, each tick for its time, but for no more than kMaxTick_s.  A tick that the machine held
/// up thus counts for little, and what must be over after a time must be over after that time by
/// this count on any machine.  Infinite before the first reply.
std::vector<double> CountedSilence_ms(const std::vector<TraceRow>& rows);

/// By that count no force is left: a dead server's melts within 25 ms
/// (devices/limiter/stages.h), which the first tick sees that ends later.  Not the stage's own
/// constant, which is what is tested.
inline constexpr double kForceGone_ms = 25.0 + 1e3 * kMaxTick_s;

/// Largest change of force or torque from one row to the next within [begin, end), in parts of what
/// the limiter allows for the time between them.
double LargestStep(const std::vector<TraceRow>& rows, std::size_t begin, std::size_t end,
                   const WrenchLimits& limits);

}  // namespace palpate::test
