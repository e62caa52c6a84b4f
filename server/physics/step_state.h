#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/effects.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/contact_id.h"
#include "server/physics/haptic_model.h"
#include "server/physics/limits.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/felt_solids.h"
#include "server/physics/surface/separation_front.h"

namespace palpate {

/// What friction remembers from step to step.
struct FrictionState {
  /// Cycles since a contact last slipped, up to still_cycles, where mu_s holds.  A tool that comes
  /// to a surface has not slipped.
  static constexpr int kNeverSlipped = 1 << 20;
  int still = kNeverSlipped;
  int resets = 0;          ///< FrictionModel::kChapter: consecutive steps that 2.34 has reset
  bool suspended = false;  ///< no friction: for the walk to a start pose
  // The forces that the solver starts from, in metres (times k_t: newtons): coulomb.
  int contacts = 0;
  std::array<ContactId, 7> id;
  std::array<double, 7> normal_force;
  std::array<Vec3, 7> force;  ///< in W

  /// To be called where no row is active: what touches next has not slipped.
  void Forget() noexcept {
    still = kNeverSlipped;
    resets = 0;
    contacts = 0;
  }
};

/// What one step hands to the next: all the memory that the physics has.  Copying it and stepping
/// again with the same pose gives the same bits; a copy has no room to spare, so that its first
/// steps may allocate, unless it is assigned to a state that was made with the model.
struct StepState {
  StepState() = default;
  /// Allocates what the model's features need: objects are whole, and nothing is known of what
  /// keeps their meshes from the tool's.  A state made without its model cuts nothing, and its
  /// first step between meshes allocates.
  explicit StepState(const HapticModel& model) : effects(model.effects().Begin()) {
    if (model.tool_body() != nullptr) {
      front.Reserve();
      if (!model.boxes().empty()) felt = FeltSolids(model.uncut());
    }
    cutting = model.cutting() == nullptr || !model.cutting()->sense;
    for (const CutSolid& solid : model.solids()) {
      cuts.emplace_back(*solid.grid, kMostGridBytes, "solid " + std::to_string(cuts.size()));
    }
  }

  Pose X_WG;                            ///< graphic tool
  Pose X_WH;                            ///< haptic tool: how far the hand moved sets the bounds
  std::array<ContactId, 7> active_ids;  ///< rows that held it last, the solver's first guess
  int active = 0;
  std::span<const ContactId> Active() const {
    return {active_ids.data(), static_cast<std::size_t>(active)};
  }
  /// Between meshes: bounds of the next sub-step where the last cycle ended before the tool had
  /// arrived; else 0.
  StepBounds behind{0.0, 0.0};
  /// How far the hand is turned from a tool that something holds, in the tool's frame (TargetFrom).
  Vec3 turn_G = Vec3::Zero();
  SeparationFront front;  ///< where objects are felt by their meshes
  FeltSolids felt;        ///< where what burs cut is
  bool spins = true;      ///< a bur: else it is a rigid tool
  /// Whether the tool cuts, in this step or the last: a bur that spins, an edge that is drawn.  Its
  /// head is felt by its samples then, and all else of it by its mesh.
  bool cutting = true;
  double drawn = 0.0;  ///< of an edge: what of kDraw a hand has drawn it in its sense [m]
  FrictionState friction;
  std::vector<CutField> cuts;  ///< what is gone of each solid
  /// What material drags the tool by where its bur spins, of the last 20 ms, of [v; rho phi] [m].
  std::array<double, 6> drag{};
  double tooth = 0.0;   ///< how far a bur's next tooth has come that hums, 0 to 1
  EffectState effects;  ///< of a state made without its model: none act

  /// To be called where the graphic tool is set to another place, or `cuts` are: nothing held it
  /// there.
  void ForgetContact() noexcept {
    active = 0;
    behind = {0.0, 0.0};
    turn_G.setZero();
    friction = FrictionState{};
    drag = {};
    felt.Forget();
  }
};

}  // namespace palpate
