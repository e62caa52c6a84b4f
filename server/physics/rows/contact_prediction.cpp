#include "server/physics/rows/contact_prediction.h"

#include <algorithm>
#include <limits>

#include "server/physics/stage_clock.h"
#include "server/physics/surface/body_surfaces.h"

namespace palpate {
namespace {
/// Surfaces that overlap by less than this touch [m].
constexpr double kTouching = 1e-6;
/// What a sub-step makes good in full of an overlap [m].  A step leaves some micrometres of
/// linearisation error; what reads deeper is as likely a point that is "below" a face from beside
/// it, across an edge, and rows that want it out at once, against others that hold, would throw the
/// optimum centimetres away, and the force with it.
constexpr double kRecovery = 5e-6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}  // namespace

ContactPrediction::ContactPrediction(const HapticModel& model)
    : query_(model.tool(), model.objects()) {
  if (model.tool_surface() != nullptr) {
    surface_.emplace(*model.tool_surface(), *model.object_surfaces());
  }
}

void ContactPrediction::Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                const Vec3& p_W, const StepBounds& bounds, const LeafWear& wear,
                                ContactRows& rows, StageTimes* times) noexcept {
  rows.Clear();
  StageClock clock(times);
  query_.Run(kernels, R_WG, p_W, bounds, [&](NodePair* pairs, int found) {
    const int count = wear.KeepPresent(pairs, found);
    clock.Lap(&StageTimes::prediction);
    rows.Add(kernels, model.tool().leaves().data(), model.objects().leaves().data(), R_WG, p_W,
             pairs, count);
    clock.Lap(&StageTimes::rows);
    return true;
  });
  clock.Lap(&StageTimes::prediction);
  if (surface_) {
    surface_->Predict(kernels, R_WG, p_W, bounds, kSurfaceDepth, kRecovery,
                      model.degrees_of_freedom(), model.rotation_length(), rows, times);
  }
  rows.Finish();
}

bool ContactPrediction::Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                 const Vec3& p_W, const LeafWear& wear,
                                 ContactRows& rows) noexcept {
  const SoftLeaves* soft = model.soft_leaves();
  bool overlaps = false;
  query_.Run(kernels, R_WG, p_W, {0.0, 0.0}, [&](NodePair* pairs, int found) {
    const int count = wear.KeepPresent(pairs, found);
    // A few pairs at a time: deep inside, the first one tells.
    constexpr int kFew = 64;
    for (int i = 0; i < count && !overlaps; i += kFew) {
      rows.Clear();
      rows.Add(kernels, model.tool().leaves().data(), model.objects().leaves().data(), R_WG, p_W,
               pairs + i, std::min(kFew, count - i));
      for (int r = 0; r < rows.count() && !overlaps; ++r) {
        const double depth = soft != nullptr ? soft->of(rows.pair(r)).depth : 0.0;
        overlaps = rows.gap(r) + depth < 0.0;
      }
    }
    return !overlaps;
  });
  if (surface_ && !overlaps) {
    rows.Clear();
    surface_->Predict(kernels, R_WG, p_W, {kTouching, 0.0}, kInfinity, kInfinity,
                      model.degrees_of_freedom(), model.rotation_length(), rows, nullptr);
    for (int r = 0; r < rows.count() && !overlaps; ++r) overlaps = rows.gap(r) < -kTouching;
  }
  return overlaps;
}

}  // namespace palpate
