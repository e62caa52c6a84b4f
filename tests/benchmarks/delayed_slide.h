#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// A hand slides over an object and gets its forces late.  Measures how much they differ from those
/// of a server that answers at once.
struct DelayedSlide {
  double speed_m_s = 0.1;
  int delay_ms = 10;  ///< from a pose to its reply
};

/// The ticks of a slide in which F_now, the step's force without delay, exceeds 0.5 N.
struct SlideTicks {
  std::vector<double> late;   ///< |F - F_now| / |F_now| of the reply's wrench itself
  std::vector<double> local;  ///< the same for PoseLead and LocalContactModel
  double force_N = 0.0;       ///< sum of |F_now|
  std::size_t beyond_region = 0;
  std::size_t sought = 0;  ///< number of all ticks, also those without such a force
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

/// @param hand  path of the hand, one pose per millisecond: AtSpeed.
SlideTicks MeasureDelayedSlide(const HapticModel& model, const std::vector<Pose>& hand,
                               const DelayedSlide& slide);
/// Returns the errors over the ticks of all slides, all with equal weight.
SlideErrors ErrorsOf(std::span<const SlideTicks> slides);

/// Returns the poses along a path, one per millisecond, at a speed [m/s].
std::vector<Pose> AtSpeed(const std::vector<Pose>& way, double speed_m_s);

/// A path over bunny-bunny.
struct SlidePath {
  std::string name;
  std::vector<Pose> hand;
};
/// "script": along the fixed bunny's back, where the scene's own script slides.  Then `seeded`
/// random ones: the tool, with any orientation, is put on the object from any side and slid in any
/// direction for `length_m`, with its hand kSlideDepth_m below the graphic tool.
inline constexpr double kSlideDepth_m = 2.5e-3;
std::vector<SlidePath> SlidePaths(const HapticModel& model, int seeded, std::uint64_t seed,
                                  double length_m = 0.1);

}  // namespace palpate::bench
