#pragma once

#include <pybind11/pybind11.h>

#include "client/python/prose.h"

namespace palpate {

void DefineBatch(py::module_& module, const Prose& prose);

}  // namespace palpate
