#pragma once

#include <cstdint>
#include <span>
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

/// The ticks of a slide in which the step's force without any delay, F_now, is more than 0.5 N.
struct SlideTicks {
  std::vector<double> late;   ///< |F - F_now| / |F_now| of the reply's wrench as it came
  std::vector<double> local;  ///< of what a station makes of replies: PoseLead, LocalContactModel
  double force_N = 0.0;       ///< sum of |F_now|
  std::size_t beyond_region = 0;
  std::size_t sought = 0;  ///< all ticks, also those without such a force
};

struct SlideError {
  double mean = 0.0, p50 = 0.0, p99 = 0.0, max = 0.0;
};
struct SlideErrors {
  SlideError late, local;
  std::size_t ticks = 0;
  double mean_force_N = 0.0;
  double contact = 0.0;        ///< share of all ticks
  double beyond_region = 0.0;  ///< share of the ticks in contact
};

/// @param hand  the way of the hand, a pose a millisecond: AtSpeed.
SlideTicks MeasureDelayedSlide(const HapticModel& model, const std::vector<Pose>& hand,
                               const DelayedSlide& slide);
/// Of the ticks of all slides, each tick as much as any other.
SlideErrors ErrorsOf(std::span<const SlideTicks> slides);

/// The poses along a way, one a millisecond at that speed [m/s].
std::vector<Pose> AtSpeed(const std::vector<Pose>& way, double speed_m_s);

/// A way over bunny-bunny.
struct SlidePath {
  std::string name;
  std::vector<Pose> hand;
};
/// "script": along the fixed bunny's back, where the scene's own script slides.  Then `seeded`
/// others: turned any way, the tool is put on the object from any side and slid in any direction
/// for `length_m`, its hand kSlideDepth_m below where the graphic tool is held.
inline constexpr double kSlideDepth_m = 2.5e-3;
std::vector<SlidePath> SlidePaths(const HapticModel& model, int seeded, std::uint64_t seed,
                                  double length_m = 0.1);

}  // namespace palpate::bench
