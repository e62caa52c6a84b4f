#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/python/arrays.h"
#include "client/python/meshes.h"
#include "client/python/scenes.h"
#include "client/python/signals.h"

// Bodies: from arrays to what a scene is made of.

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 ToVec3(const py::object& given, const char* what) {
  const Doubles array = ToDoubles(given, what);
  RequireShape(array.ndim() == 1 && array.shape(0) == 3, array, what, "three numbers");
  return Vec3::Map(array.data());
}

/// Issues a Python warning; other remarks are returned only on request.
void WarnOfUnit(const Body& body) {
  const std::string remark = MetresRemark(body.mesh);
  if (remark.empty()) return;
  if (PyErr_WarnEx(PyExc_UserWarning, (body.name + ": " + remark).c_str(), 1) != 0) {
    throw py::error_already_set();
  }
}

/// Returns a copy: an array with a row for each element, which is a Vec3 or a std::array.
template <class Rows>
auto FromRows(const Rows& rows) {
  using Row = typename Rows::value_type;
  using Number = std::remove_cvref_t<decltype(rows[0][0])>;
  return py::array_t<Number>(
      {static_cast<py::ssize_t>(rows.size()), py::ssize_t{sizeof(Row) / sizeof(Number)}},
      rows.data()->data());
}

/// Returns a read-only view of numbers that live as long as `owner`, without a copy.
py::array View(py::handle owner, const double* data, std::vector<py::ssize_t> shape) {
  py::array_t<double> array(std::move(shape), data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

Material ToMaterial(double static_friction, double dynamic_friction, double stiffness) {
  const std::string fault = MaterialFault(stiffness, static_friction, dynamic_friction);
  if (!fault.empty()) throw Error(fault);
  return {stiffness, static_friction, dynamic_friction};
}

}  // namespace

namespace {

void DefineBody(py::module_& module) {
  py::class_<Body, std::shared_ptr<Body>>(module, "Body")
      .def_readonly("name", &Body::name)
      .def_readonly("remarks", &Body::remarks)
      .def_property(
          "pose", [](const Body& body) { return FromPose(body.X_WB); },
          [](Body& body, const py::object& pose) { body.X_WB = ToUnitPose(pose); })
      .def_property_readonly("leaves", [](const Body& body) { return body.tree.leaves(); })
      .def_readonly("materials", &Body::materials)
      .def_property_readonly(
          "leaf_materials",
          [](const Body& body) {
            py::array_t<std::uint8_t> of(static_cast<py::ssize_t>(body.tree.leaves()));
            std::fill_n(of.mutable_data(), of.size(), std::uint8_t{0});
            std::ranges::copy(body.leaf_material, of.mutable_data());
            return of;
          })
      .def_property_readonly("vertices",
                             [](py::object self) {
                               const auto& mesh = self.cast<const Body&>().mesh;
                               return View(self, mesh.vertices[0].data(),
                                           {static_cast<py::ssize_t>(mesh.vertices.size()), 3});
                             })
      .def_property_readonly("triangles",
                             [](const Body& body) { return FromRows(body.mesh.triangles); })
      .def_property_readonly("leaf_centres",
                             [](const Body& body) {
                               std::vector<Vec3> centres;
                               for (std::size_t i = 0; i < body.tree.leaves(); ++i) {
                                 centres.emplace_back(body.tree.leaf_x[i], body.tree.leaf_y[i],
                                                      body.tree.leaf_z[i]);
                               }
                               return FromRows(centres);
                             })
      .def_property_readonly("leaf_radii",
                             [](py::object self) {
                               const auto& radii = self.cast<const Body&>().tree.leaf_radius;
                               return View(self, radii.data(),
                                           {static_cast<py::ssize_t>(radii.size())});
                             })
      .def("__repr__",
           [](const Body& body) {
             return Shown("Body", body.name, ": ", body.mesh.triangles.size(), " triangles, ",
                          body.tree.leaves(), " leaves, at ", Row(body.X_WB.p.data(), 3), " m");
           })
      .def(py::pickle(
          [](const Body& body) {
            Scene alone = ToScene({body}, {body}, "surface");
            alone.tools[0].name = body.name == "tool" ? "body" : "tool";
            alone.name = "body";
            return ToBytes(alone);
          },
          [](const py::bytes& state) { return std::move(ToScene(state).objects[0]); }));
}

void DefineMakers(py::module_& module, const Prose& prose) {
  module.def(
      "body",
      [](const std::string& name, const py::object& vertices, const py::object& triangles,
         std::size_t leaves, const std::string& contact, double static_friction,
         double dynamic_friction, double stiffness) {
        TriangleMesh mesh = ToMesh(vertices, triangles);
        BodyOptions options{.leaves = leaves,
                            .contact = ToContact(contact),
                            .material = ToMaterial(static_friction, dynamic_friction, stiffness)};
        Body body;
        {
          const py::gil_scoped_release free;
          options.progress = [check = SignalCheck()](auto, auto) mutable { check(); };
          body = MakeBody(name, std::move(mesh), options);
        }
        WarnOfUnit(body);
        return body;
      },
      py::arg("name"), py::arg("vertices"), py::arg("triangles") = py::none(), py::kw_only(),
      py::arg("leaves") = 0, py::arg("contact") = "surface", py::arg("static_friction") = 0.0,
      py::arg("dynamic_friction") = 0.0, py::arg("stiffness") = kInfinity, prose("body"));
  module.def(
      "ball",
      [](const std::string& name, double radius) {
        Body ball = MakeBall(name, radius);
        WarnOfUnit(ball);
        return ball;
      },
      py::arg("name"), py::arg("radius"), prose("ball"));
  const auto arrays = [](const TriangleMesh& mesh) {
    return py::make_tuple(FromRows(mesh.vertices), FromRows(mesh.triangles));
  };
  module.def(
      "box", [=](const py::object& size) { return arrays(MakeBox(ToVec3(size, "size"))); },
      py::arg("size"), prose("box"));
  module.def(
      "ellipsoid",
      [=](const py::object& semi_axes, std::size_t triangles) {
        return arrays(MakeEllipsoid(ToVec3(semi_axes, "semi_axes"), triangles));
      },
      py::arg("semi_axes"), py::arg("triangles") = 5120, prose("ellipsoid"));
}

}  // namespace

void DefineBodies(py::module_& module, const Prose& prose) {
  DefineBody(module);
  DefineMakers(module, prose);
  py::class_<Material>(module, "Material")
      .def_readonly("name", &Material::name)
      .def_readonly("stiffness", &Material::stiffness)
      .def_readonly("static_friction", &Material::static_friction)
      .def_readonly("dynamic_friction", &Material::dynamic_friction)
      .def("__repr__", [](const Material& m) {
        return Shown("Material", m.name.empty() ? "" : m.name + ": ", "stiffness ", m.stiffness,
                     " N/m, friction ", m.static_friction, " static, ", m.dynamic_friction,
                     " dynamic");
      });
}

}  // namespace palpate
