#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// A hand slides over an object, and the forces that it is given come late: how far are they from
/// those of a server that answers at once?
struct DelayedSlide {
  double speed_m_s = 0.1;
  int delay_ms = 10;  ///< from a pose to its reply
};

/// |F - F_now| / |F_now| over the ticks in which F_now, the step's force without any delay, is more
/// than 0.5 N.
struct SlideError {
  double mean = 0.0, p99 = 0.0, max = 0.0;
};
struct SlideErrors {
  SlideError late;   ///< of the reply's wrench as it came
  SlideError local;  ///< of the local contact model
  std::size_t ticks = 0;
  double mean_force_N = 0.0;
  double beyond_region = 0.0;  ///< share of the ticks
};

/// @param hand  the way of the hand, of any speed: it is played at that of the experiment.
SlideErrors MeasureDelayedSlide(const HapticModel& model, const std::vector<Pose>& hand,
                                const DelayedSlide& slide);

/// The poses along a way, one a millisecond at that speed [m/s].
std::vector<Pose> AtSpeed(const std::vector<Pose>& way, double speed_m_s);

}  // namespace palpate::bench
