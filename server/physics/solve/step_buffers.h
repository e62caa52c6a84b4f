#pragma once

#include <optional>

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/solve/energies.h"

namespace palpate {

/// The scratch of a step, allocated once: what a StepWorkspace holds.
struct StepBuffers {
  explicit StepBuffers(const HapticModel& model)
      : prediction(model),
        rows(model.parameters().max_rows, PairQuery::kMaxBatch, model.degrees_of_freedom(),
             model.rotation_length()) {
    if (model.tool_body() != nullptr) {
      meshes.emplace(*model.tool_body(), model.bodies(), model.parameters().max_rows,
                     model.parameters().separation, model.parameters().looks);
    }
    if (model.soft_leaves() != nullptr || model.cuts()) {
      energies.emplace(model);
    }
  }
  ContactPrediction prediction;
  ContactRows rows;
  std::optional<MeshContact> meshes;  ///< where objects are felt by their meshes
  std::optional<Energies> energies;   ///< where any acts beside the coupling
};

}  // namespace palpate
