#pragma once

#include <limits>

#include "devices/simulated/phantom_sheets.h"
#include "devices/wrench_limiter.h"

namespace palpate::test {

inline constexpr double kTick = 1e-3;  ///< of a loop at 1 kHz [s]
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();

inline WrenchLimits PhantomLimits() {
  return WrenchLimits::Of(PhantomPremium30().info);
}

}  // namespace palpate::test
