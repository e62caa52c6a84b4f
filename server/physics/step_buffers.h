#pragma once

#include "server/physics/contact_prediction.h"
#include "server/physics/contact_rows.h"
#include "server/physics/haptic_step.h"

namespace palpate {

/// What a StepWorkspace holds.
struct StepWorkspace::Buffers {
  explicit Buffers(const HapticModel& model)
      : prediction(model),
        rows(model.parameters().max_rows, PairQuery::kMaxBatch, model.degrees_of_freedom(),
             model.rotation_length()) {}
  ContactPrediction prediction;
  ContactRows rows;
};
using StepBuffers = StepWorkspace::Buffers;

}  // namespace palpate
