#pragma once

#include <memory>
#include <optional>
#include <string>

#include <pybind11/pybind11.h>

#include "client/python/hand.h"
#include "client/python/prose.h"
#include "server/library/physics.h"

namespace palpate {

/// All that a proxy's next step depends on beside its pose and the effect's function.
struct State {
  std::shared_ptr<const HapticModel> model;  ///< null: `bytes` are the state, from pickle
  ProxyState proxy;
  std::string bytes;
  std::optional<SlowEffect::Memory> effect;
};

State StateOf(Hand& hand);
/// Throws Error if the state is of another model.
void SetState(Hand& hand, const State& state);
/// Returns a proxy that stands where a state says, with the same effect.
std::unique_ptr<Hand> Copy(Hand& hand);

/// Throws Error if what pickle loads was stored by a build of another physics revision.
void RequireRevision(const py::object& revision, const char* what);

void DefineStates(py::module_& module, py::class_<Hand>& proxy, const Prose& prose);

}  // namespace palpate
