#pragma once

#include <memory>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "server/library/physics.h"

namespace palpate {

namespace py = pybind11;

/// The parameters that something was made with.
using Used = std::shared_ptr<const std::vector<Parameter>>;

/// A model and the parameters that it was made with; proxies keep it alive.
struct Shared {
  std::shared_ptr<const HapticModel> model;
  std::string scene, tool;
  Used parameters;
  std::shared_ptr<const Scene> made_of;  // for pickle
  std::size_t tool_index = 0;
};

/// Makes a model of a tool by its index, without Python's lock.
Shared Share(Scene scene, std::size_t tool);

py::dict ToDict(const std::vector<Parameter>& parameters);
Used FromDict(const py::dict& values);

}  // namespace palpate
