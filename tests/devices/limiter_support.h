#pragma once

#include "devices/wrench_limiter.h"

namespace palpate {

/// A limiter that passes everything: its device has such wide bounds, and was enabled so long ago,
/// that each wrench up to 100 N and 100 N m comes out as it went in.  Tests, too, can only command
/// a device through a limiter.
class OpenLimiter {
 public:
  OpenLimiter() : limiter_(WrenchLimits::Of(Wide())) {
    limiter_.Enable(true);
    for (int i = 0; i < 125; ++i) Pass({});
  }
  LimitedWrench Pass(const Wrench& wrench) {
    LimiterInput in;
    in.wanted = wrench;
    in.silence_s = in.age_s = 0.0;
    in.dt_s = kMaxTick_s;
    return limiter_.Limit(in);
  }

 private:
  static DeviceInfo Wide() {
    DeviceInfo info;
    info.max_force_N = info.continuous_force_N = 1e4;
    info.max_torque_Nm = info.continuous_torque_Nm = 1e4;
    return info;
  }

  WrenchLimiter limiter_;
};

/// Passes one wrench.
inline LimitedWrench PassThrough(const Wrench& wrench) {
  static const OpenLimiter past_its_ramps;
  OpenLimiter limiter = past_its_ramps;
  return limiter.Pass(wrench);
}

}  // namespace palpate
