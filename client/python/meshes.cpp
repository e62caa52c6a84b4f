#include "client/python/meshes.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include <pybind11/numpy.h>

#include "client/python/arrays.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/mesh/mesh_export.h"

// Meshes: from arrays, and into files.

namespace palpate {
namespace {

/// Converts an integer of any type; MakeBody checks that it is a valid vertex index.
std::uint32_t ToIndex(double index) {
  if (!(index >= 0.0 && index <= std::numeric_limits<std::uint32_t>::max()) ||
      index != std::floor(index)) {
    throw Error("triangles: " + py::str(py::float_(index)).cast<std::string>() +
                " is not a vertex; give whole numbers from 0");
  }
  return static_cast<std::uint32_t>(index);
}

}  // namespace

TriangleMesh ToMesh(const py::object& given_vertices, const py::object& given_triangles) {
  if (given_triangles.is_none()) {
    const py::tuple both = py::module_::import("palpate.meshes").attr("arrays")(given_vertices);
    return ToMesh(both[0], both[1]);
  }
  const Doubles vertices = ToDoubles(given_vertices, "vertices");
  // Integers beyond 2^53 lose digits, but they are no valid vertices.
  const Doubles triangles = ToDoubles(given_triangles, "triangles");
  const auto is_rows_of_three = [](const py::array& a) { return a.ndim() == 2 && a.shape(1) == 3; };
  RequireShape(is_rows_of_three(vertices), vertices, "vertices", "an array (n, 3)");
  RequireShape(is_rows_of_three(triangles), triangles, "triangles",
               "an array (m, 3) of vertices from 0");
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::size_t>(vertices.shape(0)));
  std::memcpy(static_cast<void*>(mesh.vertices.data()), vertices.data(),
              sizeof(Vec3) * mesh.vertices.size());
  mesh.triangles.resize(static_cast<std::size_t>(triangles.shape(0)));
  const double* index = triangles.data();
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = ToIndex(*index++);
  }
  return mesh;
}

void DefineMeshes(py::module_& module) {
  module.def("_mesh_bytes", [](const std::string& file, const py::object& vertices,
                               const py::object& triangles, double metres_per_unit) {
    return py::bytes(ExportMesh(
        ToMesh(vertices, triangles), file,
        {.metres_per_unit = metres_per_unit, .comment = "written by palpate " PALPATE_VERSION}));
  });
  module.def("_write_file", [](const std::string& file, const py::bytes& bytes) {
    const auto text = std::string_view(bytes);
    WriteFileAtomically(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  });
}

}  // namespace palpate
