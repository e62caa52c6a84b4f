#include "devices/spacemouse/rate_control.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double RateControl::Share(double counts) noexcept {
  const double beyond = std::max(0.0, std::abs(counts) - kDeadBand);
  const double share = std::min(1.0, beyond / (kFullDeflection - kDeadBand));
  return std::copysign(share * share, counts);
}

Twist RateControl::Velocity(const std::array<int, 6>& axes) noexcept {
  // libspnav turns z round in the same way, for rotations too (spnav_posrot_moveobj).
  return {kTopSpeed_m_s * Vec3(Share(axes[0]), Share(axes[1]), -Share(axes[2])),
          kTopTurn_rad_s * Vec3(Share(axes[3]), Share(axes[4]), -Share(axes[5]))};
}

}  // namespace palpate
