#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/effects.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/energy/energy.h"
#include "server/physics/energy/inertia.h"
#include "server/physics/haptic_model.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/separation_front.h"
#include "server/physics/surface/solid_bodies.h"

namespace palpate {

/// The ids of the rows that hold a tool, which are a solver's first guess.
struct ActiveIds {
  int count = 0;
  std::array<ContactId, 7> id;

  operator std::span<const ContactId>() const {
    return {id.data(), static_cast<std::size_t>(count)};
  }
};

/// What friction remembers from step to step.
struct FrictionState {
  /// Cycles since a contact last slipped; from `still_cycles` on, mu_s applies.  A tool that has
  /// just reached a surface counts as not having slipped.
  static constexpr int kNeverSlipped = 1 << 20;
  int still = kNeverSlipped;
  int resets = 0;          ///< FrictionModel::kChapter: consecutive steps reset by 2.34
  bool suspended = false;  ///< turns friction off, during the walk to a start pose
  // FrictionModel::kCoulomb: the forces that the solver starts from [m]; times k_t, newtons.
  int contacts = 0;
  std::array<ContactId, 7> id;
  std::array<double, 7> normal_force;
  std::array<Vec3, 7> force;  ///< in W

  /// Call when no row is active: the next contact has not slipped yet.
  void Forget() noexcept {
    still = kNeverSlipped;
    resets = 0;
    contacts = 0;
  }
};

/// What a tool that cuts remembers from step to step, and what it has removed.
struct CuttingState {
  std::vector<CutField> fields;  ///< what has been removed from each solid
  bool spins = true;             ///< whether the bur spins; if not, it is a rigid tool
  /// Whether the tool cuts, in this step or the last: a bur while it spins, an edge while it is
  /// drawn.  Its head then touches by its samples, the rest of the tool by its mesh.
  bool acts = true;
  double drawn = 0.0;  ///< edge: how far the hand has drawn it in its sense, at most kDraw [m]
  /// Drag of the material on a spinning bur, smoothed over the last 20 ms, as [v; rho phi] [m].
  Vec6 drag = Vec6::Zero();
  double tooth = 0.0;  ///< phase of the tooth frequency of the vibration, 0 to 1
};

/// Where a frame is whose bodies are not there: a tool that no hand holds [m].
inline const Vec3 kAway{1e4, 0.0, 0.0};

/// A frame B of bodies that stand still to each other, and move in W.  Frame 0 is W itself.
struct BodyFrame {
  Pose X_WB;              ///< where its bodies are, relative to where the model has placed them
  Pose X_WB_next;         ///< where they are to be at the end of the next step; set before it
  SeparationFront front;  ///< planes between the tool and its bodies that are touched by meshes

  /// Takes its bodies away: nothing touches them.
  void Leave() noexcept {
    X_WB = X_WB_next = {kAway, Quat::Identity()};
    front.Clear();
  }
};

/// The state that one step passes to the next: all memory of the physics.  A copy that is stepped
/// with the same poses gives the same bits.  A copy has no spare capacity, so its first steps may
/// allocate, unless it is assigned to a state that was constructed from the model.
struct StepState {
  StepState() = default;
  /// Allocates what the model's features need.  Nothing has been cut, and no separating planes are
  /// known.  A default-constructed state cuts nothing, and its first step between meshes allocates.
  explicit StepState(const HapticModel& model) : effects(model.effects().Begin()) {
    if (model.tool_body() != nullptr) {
      MakeFrames(model.bodies());
      for (BodyFrame& frame : frames) frame.front.Reserve();
      if (!model.boxes().empty()) solids = SolidBodies(model.uncut());
    }
    cut.acts = model.cutting() == nullptr || !model.cutting()->sense;
    for (const CutSolid& solid : model.solids()) {
      cut.fields.emplace_back(*solid.grid, kMostGridBytes,
                              "solid " + std::to_string(cut.fields.size()));
    }
  }

  Pose X_WG;         ///< graphic tool
  Pose X_WH;         ///< haptic tool: how far the hand moves from here sets the bounds
  ActiveIds active;  ///< of the rows that last held the tool
  /// Between meshes: bounds of the next sub-step if the last cycle ended before the tool had
  /// arrived; else 0.
  StepBounds behind{0.0, 0.0};
  /// Between leaves: whether so many were near that the next cycle predicts only where the tool
  /// goes.
  bool is_crowded = false;
  /// Rotation of the hand relative to the tool while something holds the tool, in the tool's
  /// frame (TargetFrom).
  Vec3 rotation_G = Vec3::Zero();
  std::vector<BodyFrame> frames;  ///< by their number
  /// Steps that the groups of the model have made; negative: they rest (start_pose.h).
  std::int64_t moved = 0;
  SolidBodies solids;  ///< the solids that burs cut, as contact feels them
  FrictionState friction;
  CuttingState cut;
  EffectState effects;  ///< without effect in a default-constructed state

  BodyState body;  ///< if it is a free body's

  /// Makes the frames of these bodies; other tools are not there.
  void MakeFrames(std::span<const ContactBody> bodies) {
    frames.resize(CountFrames(bodies));
    for (const ContactBody& of : bodies) {
      if (of.tool >= 0 && !of.is_body) frames[static_cast<std::size_t>(of.frame)].Leave();
    }
  }
  /// Puts the groups of the model, so many, where they begin.
  void RestMoved(std::size_t groups) noexcept {
    moved = 0;
    for (std::size_t i = 1; i < frames.size() && i <= groups; ++i) {
      frames[i].X_WB = frames[i].X_WB_next = Pose{};
      frames[i].front.Clear();
    }
  }

  /// Call when the graphic tool or `cut.fields` are set from outside: no contact is known any more.
  void ForgetContact() noexcept {
    active.count = 0;
    behind = {0.0, 0.0};
    is_crowded = false;
    rotation_G.setZero();
    friction = FrictionState{};
    cut.drag.setZero();
    solids.Forget();
  }
};

}  // namespace palpate
