#pragma once

#include "devices/wrench_limiter.h"

namespace palpate {

/// What a limiter lets through when all is well: a device with bounds so wide, and a past so long,
/// that the wrench comes out as it went in.  The only way for a test, too, to command a device.
inline LimitedWrench PassThrough(const Wrench& wrench) {
  LimiterInput in;
  in.silence_s = in.age_s = 0.0;
  in.dt_s = kMaxTick_s;
  static const WrenchLimiter past_its_ramps = [&] {
    DeviceInfo info;
    info.max_force_N = info.continuous_force_N = 1e4;
    info.max_torque_Nm = info.continuous_torque_Nm = 1e4;
    WrenchLimiter limiter(WrenchLimits::Of(info));
    limiter.Enable(true);
    for (int i = 0; i < 125; ++i) limiter.Limit(in);
    return limiter;
  }();
  WrenchLimiter limiter = past_its_ramps;
  in.wanted = wrench;
  return limiter.Limit(in);
}

}  // namespace palpate
