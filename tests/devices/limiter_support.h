#pragma once

#include "devices/wrench_limiter.h"

namespace palpate {

/// What a limiter lets through when all is well: a device with bounds so wide, and a past so long,
/// that the wrench comes out as it went in.  The only way for a test, too, to command a device.
inline LimitedWrench PassThrough(const Wrench& wrench) {
  DeviceInfo info;
  info.max_force_N = info.continuous_force_N = 1e3;
  info.max_torque_Nm = info.continuous_torque_Nm = 1e3;
  WrenchLimiter limiter(WrenchLimits::Of(info));
  limiter.Enable(true);
  LimiterInput in;
  in.wanted = wrench;
  in.silence_s = in.age_s = 0.0;
  in.dt_s = 1e-3;
  for (int i = 0; i < 250; ++i) limiter.Limit(in);
  return limiter.Limit(in);
}

}  // namespace palpate
