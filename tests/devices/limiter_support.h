#pragma once

#include "devices/wrench_limiter.h"

namespace palpate {

/// What a limiter lets through when all is well: bounds so wide, and a past so long, that the
/// wrench comes out as it went in.  The only way for a test, too, to command a device.
inline LimitedWrench PassThrough(const Wrench& wrench) {
  WrenchLimits limits;
  limits.force_N = limits.torque_Nm = 1e3;
  limits.force_slew_N_per_ms = limits.torque_slew_Nm_per_ms = 1e6;
  WrenchLimiter limiter(limits);
  limiter.Enable(true);
  for (int i = 0; i < 250; ++i) limiter.Limit(wrench, 0.0, 1e-3);
  return limiter.Limit(wrench, 0.0, 1e-3);
}

}  // namespace palpate
