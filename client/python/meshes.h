#pragma once

#include <pybind11/pybind11.h>

#include "server/library/physics.h"

namespace palpate {

namespace py = pybind11;

/// Returns the mesh of two arrays, (n, 3) and (m, 3), or of one object that has both
/// (palpate/meshes.py).  Throws Error.
/// @param triangles  None: `vertices` is an object.
TriangleMesh ToMesh(const py::object& vertices, const py::object& triangles);

/// What palpate/meshes.py and palpate/described.py call.
void DefineMeshes(py::module_& module);

}  // namespace palpate
