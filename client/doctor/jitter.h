#pragma once

#include <cstdint>

#include "client/doctor/finding.h"
#include "common/program/realtime.h"
#include "common/program/stop_signal.h"
#include "common/realtime/histogram.h"

namespace palpate::doctor {

/// How late a loop of 1 kHz woke up.
struct Jitter {
  Histogram lateness;        ///< [ns]
  std::uint64_t missed = 0;  ///< milliseconds that had passed before the loop woke up for them
};

/// Sleeps until each millisecond of the monotonic clock, in a thread with the rights of a loop.
/// Throws UsageError where realtime.cpu does not exist.
Jitter MeasureJitter(double seconds, const RealtimeOptions& realtime, StopSignal& stop);

/// Whether that leaves a pose its time.
Finding CheckJitter(const Jitter& jitter);

}  // namespace palpate::doctor
