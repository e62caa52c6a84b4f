#include "server/physics/rows/contact_prediction.h"

#include <algorithm>

#include "common/math/rotation.h"
#include "server/physics/limits.h"

namespace palpate {

ContactPrediction::ContactPrediction(const HapticModel& model) {
  if (model.insides() != nullptr) insides_.emplace(model.tool(), *model.insides());
  if (!model.objects().any) return;
  query_.emplace(model.tool(), model.objects());
  least_radii_ = std::ranges::min(model.tool().leaves, {}, &LeafSphere::radius).radius +
                 std::ranges::min(model.objects().leaves, {}, &LeafSphere::radius).radius;
}

bool ContactPrediction::Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                const Vec3& p_W, const StepEnds& ends, ContactRows& rows,
                                StageTimes* times, bool may_crowd) noexcept {
  rows.Clear();
  bool fits = true;
  if (query_) {
    StepBounds bounds = ends.bounds;
    Mat3 R_end = R_WG;
    if (ends.v != Vec3::Zero() || ends.phi != Vec3::Zero()) {
      R_end = RotationExp(ends.phi).toRotationMatrix() * R_WG;
      const double length = ends.v.norm() + bounds.translation +
                            (ends.phi.norm() + bounds.rotation) * model.tool().max_lever;
      bounds.translation += std::min(length, length * length / (2.0 * least_radii_));
    }
    const std::int64_t before = tested();
    const auto is_crowd = [&](int count) {
      return count > limits::kCrowd && count > limits::kCrowdATest * (tested() - before);
    };
    StageClock clock(times);
    query_->Run(kernels, R_end, p_W + ends.v, bounds, [&](NodePair* pairs, int count) {
      clock.Lap(&StageTimes::prediction);
      fits = (may_crowd || !is_crowd(rows.count() + count)) &&
             rows.Add(kernels, model.tool().leaves.data(), model.objects().leaves.data(), R_WG, p_W,
                      pairs, count);
      clock.Lap(&StageTimes::rows);
      return fits;
    });
    clock.Lap(&StageTimes::prediction);
  }
  rows.Finish();
  return fits;
}

void ContactPrediction::Take(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                             const Vec3& p_W, std::span<const ContactId> ids,
                             ContactRows& rows) noexcept {
  rows.Clear();
  for (const ContactId& id : ids) {
    const NodePair pair{id.a, id.b};
    if (!rows.Add(kernels, model.tool().leaves.data(), model.objects().leaves.data(), R_WG, p_W,
                  &pair, 1)) {
      break;
    }
  }
  rows.Finish();
}

bool ContactPrediction::Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                 const Vec3& p_W) noexcept {
  bool overlaps = false;
  const auto search = [&](PairQuery& query, const ObjectForest& forest, const auto& depth_of) {
    query.Run(kernels, R_WG, p_W, {0.0, 0.0}, [&](NodePair* pairs, int count) {
      // Deep inside an object, the first one decides.
      for (int i = 0; i < count && !overlaps; ++i) {
        const LeafSphere& t = model.tool().leaves[static_cast<std::size_t>(pairs[i].tool)];
        const LeafSphere& o = forest.leaves[static_cast<std::size_t>(pairs[i].object)];
        const Vec3 apart = R_WG * Vec3(t.x, t.y, t.z) + p_W - Vec3(o.x, o.y, o.z);
        overlaps = apart.norm() - (t.radius + o.radius) + depth_of(pairs[i].object) < 0.0;
      }
      return !overlaps;
    });
  };
  const ObjectForest& objects = model.objects();
  const auto core_depth = [&](std::int32_t leaf) {
    const double radius = objects.leaves[static_cast<std::size_t>(leaf)].radius;
    return model.yields() ? CoreDepth(objects.MaterialOf(leaf), radius) : 0.0;
  };
  if (query_) search(*query_, objects, core_depth);
  if (insides_ && !overlaps) {
    search(*insides_, *model.insides(), [](std::int32_t) { return limits::kCoreDepth; });
  }
  return overlaps;
}

}  // namespace palpate
