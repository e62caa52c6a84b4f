#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/physics/haptic_model.h"
#include "server/physics/step_state.h"

namespace palpate {

/// A proxy's state, to continue from it later, elsewhere or several times.
struct ProxyState {
  StepState step;
  double start_depth = 0.0;  ///< Proxy::start_depth
};

/// Returns a state as bytes: for files, other processes, and another host's same build.  They name
/// the physics revision (common/revision.h) and the model.
/// Throws Error if the model has solids that burs cut: copy such a state in the process instead.
std::vector<std::uint8_t> ToBytes(const HapticModel& model, const ProxyState& state);

/// Takes a state from bytes.  A proxy that gets it continues to the bits of the original.
/// Throws Error for anything but bytes that ToBytes of the same revision made, for a model of the
/// same content; whatever the bytes are, the state that it returns is safe to step.
ProxyState StateOf(const HapticModel& model, std::span<const std::uint8_t> bytes);

/// Returns a hash of all that the bits of a step depend on in a model; goes through its meshes.
std::uint64_t ContentOf(const HapticModel& model);

}  // namespace palpate
