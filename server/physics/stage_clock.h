#pragma once

#include <chrono>

#include "server/physics/step_types.h"

namespace palpate {

/// Times the stages of a step for benchmarks.  Reads no clock if `times` is null.
class StageClock {
 public:
  explicit StageClock(StageTimes* times) : times_(times) {
    if (times_ != nullptr) last_ = std::chrono::steady_clock::now();
  }
  /// Adds the time since the last lap to a stage.
  void Lap(std::int64_t StageTimes::*stage) {
    if (times_ == nullptr) return;
    const auto now = std::chrono::steady_clock::now();
    times_->*stage += std::chrono::duration_cast<std::chrono::nanoseconds>(now - last_).count();
    last_ = now;
  }

 private:
  StageTimes* times_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace palpate
