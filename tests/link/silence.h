#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "devices/wrench_limiter.h"
#include "tests/link/trace_file.h"

namespace palpate::test {

/// What a hand felt while its server was silent, from the station's trace.
struct Silence {
  double share_before = 0.0;           ///< of what was wanted, applied when the last reply came
  double counted_until_zero_ms = 0.0;  ///< by CountedSilence_ms, of the first tick without a wrench
  bool stayed_zero = false;            ///< until the next reply
  double largest_step = 0.0;   ///< between two ticks, over the slew limit; includes the way back
  double until_back_ms = 0.0;  ///< from the next reply until the share is back
};

/// The first silence of at least 30 ms after `after_ns`.  Throws Error where the trace has none
/// that begins and ends with a force.
Silence MeasureSilence(const std::vector<TraceRow>& rows, std::int64_t after_ns,
                       const WrenchLimits& limits);

/// Silence at each row as the limiter counts it: from the row that took the last reply, each tick
/// counts its duration, but at most kMaxTick_s.  Late ticks thus count for little, and a deadline
/// by this count holds on any machine.  Infinite before the first reply.
std::vector<double> CountedSilence_ms(const std::vector<TraceRow>& rows);

/// By that count no force is left after this time.  A dead server's force fades within 25 ms
/// (devices/limiter/stages.h), and the next tick sees it.  Not computed from the stage's constant,
/// which is what is tested.
inline constexpr double kForceGone_ms = 25.0 + 1e3 * kMaxTick_s;

/// Largest change of force or torque between two rows in [begin, end), over what the limiter allows
/// in the time between them.
double LargestStep(const std::vector<TraceRow>& rows, std::size_t begin, std::size_t end,
                   const WrenchLimits& limits);

}  // namespace palpate::test
