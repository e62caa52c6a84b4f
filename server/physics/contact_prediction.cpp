#include "server/physics/contact_prediction.h"

#include "server/physics/stage_clock.h"

namespace palpate {

ContactPrediction::ContactPrediction(const HapticModel& model)
    : query_(model.tool(), model.objects()) {}

void ContactPrediction::Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                                const Vec3& p_W, ContactRows& rows, StageTimes* times) noexcept {
  rows.Clear();
  StageClock clock(times);
  query_.Run(kernels, R_WG, p_W, [&](const NodePair* pairs, int count) {
    clock.Lap(&StageTimes::prediction);
    rows.Add(kernels, model.tool().leaves().data(), model.objects().leaves().data(), R_WG, p_W,
             pairs, count);
    clock.Lap(&StageTimes::rows);
  });
  rows.Finish();
  clock.Lap(&StageTimes::prediction);
}

}  // namespace palpate
