#include "server/physics/rows/contact_prediction.h"

#include <algorithm>

#include "server/physics/limits.h"

namespace palpate {
namespace {

/// Ratio of the reach for the tightest rows to that of the step before.  Taken.
constexpr double kNear = 1.1;

}  // namespace

ContactPrediction::ContactPrediction(const HapticModel& model) {
  if (model.objects().any) query_.emplace(model.tool(), model.objects());
  if (model.insides() != nullptr) insides_.emplace(model.tool(), *model.insides());
}

void ContactPrediction::Gather(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                               const Vec3& p_W, const StepBounds& bounds, ContactRows& rows,
                               StageTimes* times) noexcept {
  rows.Clear();
  StageClock clock(times);
  query_->Run(kernels, R_WG, p_W, bounds, [&](NodePair* pairs, int count) {
    clock.Lap(&StageTimes::prediction);
    rows.Add(kernels, model.tool().leaves.data(), model.objects().leaves.data(), R_WG, p_W, pairs,
             count);
    clock.Lap(&StageTimes::rows);
    return true;
  });
  clock.Lap(&StageTimes::prediction);
  rows.Finish();
  clock.Lap(&StageTimes::rows);
}

// Two smooth bodies that lie along each other can bring many times more pairs within the bounds
// than there is room for.  The tightest of them are also within a shorter reach, as long as
// that reach still finds more than there is room for: a search finds all pairs up to its gap,
// in the same order.
void ContactPrediction::Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                const Vec3& p_W, const StepBounds& bounds, ContactRows& rows,
                                StageTimes* times) noexcept {
  if (!query_) {
    rows.Clear();
    rows.Finish();
    return;
  }
  bool has_tightest = false;
  if (near_ > 0.0 && near_ < bounds.translation) {
    const std::int64_t before = query_->tested();
    Gather(model, kernels, R_WG, p_W, {near_, 0.0}, rows, times);
    has_tightest = rows.overflowed() && rows.loosest() <= near_;
    // The count decides about sub-steps, so a workspace that has not guessed must count the same.
    if (!has_tightest) counted_ -= query_->tested() - before;
  }
  if (!has_tightest) Gather(model, kernels, R_WG, p_W, bounds, rows, times);
  near_ = rows.overflowed() ? kNear * rows.loosest() : 0.0;
  if (rows.overflowed()) counted_ += limits::kMaxTested;
}

bool ContactPrediction::Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                 const Vec3& p_W, ContactRows& rows) noexcept {
  bool overlaps = false;
  const auto look = [&](PairQuery& query, const ObjectForest& forest, const auto& depth_of) {
    query.Run(kernels, R_WG, p_W, {0.0, 0.0}, [&](NodePair* pairs, int count) {
      // A few pairs at a time: deep inside an object, the first one decides.
      constexpr int kFew = 64;
      for (int i = 0; i < count && !overlaps; i += kFew) {
        rows.Clear();
        rows.Add(kernels, model.tool().leaves.data(), forest.leaves.data(), R_WG, p_W, pairs + i,
                 std::min(kFew, count - i));
        for (int r = 0; r < rows.count() && !overlaps; ++r) {
          overlaps = rows.gap(r) + depth_of(rows.id(r).object) < 0.0;
        }
      }
      return !overlaps;
    });
  };
  const ObjectForest& objects = model.objects();
  const auto core_depth = [&](std::int32_t leaf) {
    const double radius = objects.leaves[static_cast<std::size_t>(leaf)].radius;
    return model.yields() ? CoreDepth(objects.MaterialOf(leaf), radius) : 0.0;
  };
  if (query_) look(*query_, objects, core_depth);
  if (insides_ && !overlaps) {
    look(*insides_, *model.insides(), [](std::int32_t) { return limits::kCoreDepth; });
  }
  return overlaps;
}

}  // namespace palpate
