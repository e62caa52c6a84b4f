#include "client/python/scenes.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/python/arrays.h"
#include "client/python/model.h"
#include "client/python/signals.h"
#include "common/files/project_files.h"
#include "common/program/machine.h"
#include "scenes/files/scene_bundle.h"

// Scenes, loaded or made of bodies.

namespace palpate {

ContactModel ToContact(const std::string& contact) {
  if (contact == "surface") return ContactModel::kSurface;
  if (contact == "spheres") return ContactModel::kSpheres;
  throw Error("contact: '" + contact + "' is not known; give 'surface' or 'spheres'");
}

/// Returns the bytes that pickle stores or sends to other processes.
py::bytes ToBytes(const Scene& scene) {
  CheckPackable(scene);
  const std::vector<std::uint8_t> bytes = PackScene(scene, 0, Remarks::kKeep);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
Scene ToScene(const py::bytes& bytes) {
  const auto text = std::string_view(bytes);
  return UnpackScene({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, "pickle");
}

Scene ToScene(const std::vector<Body>& objects, const std::vector<Body>& tools,
              const std::string& contact) {
  Scene scene;
  scene.objects = objects;
  scene.tools = tools;
  scene.features.contact = ToContact(contact);
  for (const Body& object : objects) {
    for (const Material& material : object.materials) {
      if (material.static_friction > 0.0) scene.features.friction = FrictionModel::kCoulomb;
      if (std::isfinite(material.stiffness)) scene.features.compliance = true;
    }
  }
  return scene;
}

void SetParameters(Scene& scene, const py::dict& parameters) {
  for (const auto& [name, value] : parameters) {
    const auto what = name.cast<std::string>();
    // Python's float() would read text, too.
    const Doubles number = ToDoubles(py::reinterpret_borrow<py::object>(value), what);
    RequireShape(number.ndim() == 0, number, what, "a single number");
    SetParameter(scene, what, *number.data());
  }
}

namespace {

std::unique_ptr<Loaded> MakeScene(const std::vector<Body>& objects, const std::vector<Body>& tools,
                                  const std::string& name, const std::string& contact,
                                  const py::kwargs& parameters) {
  auto made = std::make_unique<Loaded>(Loaded{ToScene(objects, tools, contact), "", {}});
  made->scene.name = name;
  CheckPackable(made->scene);
  SetParameters(made->scene, parameters);
  return made;
}

void Save(const Loaded& loaded, const std::string& file) {
  SaveScene(loaded.scene, file);
  if (!loaded.script.empty()) std::ofstream(ScriptFileBeside(file)) << loaded.script;
}

std::unique_ptr<Loaded> Load(const std::string& name, const std::optional<std::string>& contact,
                             const std::optional<double>& tolerance_um, const std::string& unit) {
  auto loaded = std::make_unique<Loaded>();
  LoadOptions options;
  if (contact) options.contact = ToContact(*contact);
  if (tolerance_um) options.leaves = HeightTolerance(*tolerance_um);
  options.mesh.unit = unit;
  const auto say = [&](const std::string& what) { loaded->said.push_back(what); };
  options.warn = options.tell = say;
  ProgressLine line;
  SignalCheck check;
  options.progress = [&](std::string_view stage, double done) {
    line(stage, done);
    check();
  };
  const py::gil_scoped_release free;
  loaded->scene = LoadScene(name, options);
  const std::string script = ScriptFileBeside(name);
  if (std::filesystem::exists(script)) {
    PoseScript::Load(script);  // throws if the script is invalid
    std::ifstream file(script);
    loaded->script.assign(std::istreambuf_iterator<char>(file), {});
  }
  return loaded;
}

std::string ToPath(const py::object& file) {
  return py::module_::import("os").attr("fspath")(file).cast<std::string>();
}

std::string NamesOf(const std::vector<Body>& bodies) {
  std::string names;
  for (const Body& body : bodies) names += (names.empty() ? "" : ", ") + body.name;
  return names;
}

Shared ModelOf(const Loaded& loaded, const py::object& which, const py::kwargs& parameters) {
  Scene scene = loaded.scene;
  SetParameters(scene, parameters);
  for (std::size_t i = 0; i < scene.tools.size(); ++i) {
    const Body& tool = scene.tools[i];
    if (which.equal(py::int_(i)) || which.equal(py::str(tool.name))) {
      return Share(std::move(scene), i);
    }
  }
  throw Error("tool: " + py::str(which).cast<std::string>() + " is not in the scene; give one of " +
              NamesOf(scene.tools));
}

py::array_t<double> PathOf(const Loaded& loaded, double rate) {
  if (loaded.script.empty()) {
    throw Error(loaded.scene.name + ": has no script of a hand; give poses of your own");
  }
  const PoseScript hand = PoseScript::Parse(loaded.script, loaded.scene.name);
  if (!(rate > 0.0 && rate <= 1e5)) throw Error("rate: must be above 0, and at most 100000");
  const auto count = static_cast<py::ssize_t>(rate * hand.duration() + 1e-6) + 1;
  py::array_t<double> path({count, py::ssize_t{7}});
  for (py::ssize_t i = 0; i < count; ++i) {
    FromPose(hand.At(static_cast<double>(i) / rate), path.mutable_data(i, 0));
  }
  return path;
}

/// Returns a table of the parameters that can be varied, with the values of a default scene.
py::list Table() {
  py::list rows;
  for (const Parameter& p : ParametersOf(Scene{})) {
    py::dict row;
    row["name"] = p.name;
    row["unit"] = p.unit;
    row["default"] = p.usual;
    row["least"] = p.least;
    row["most"] = p.most;
    row["what"] = p.what;
    rows.append(row);
  }
  return rows;
}

}  // namespace

void DefineScenes(py::module_& module, const Prose& prose) {
  py::class_<Loaded>(module, "Scene")
      .def(py::init(&MakeScene), py::arg("objects"), py::arg("tools"), py::kw_only(),
           py::arg("name") = "scene", py::arg("contact") = "surface", prose("Scene.__init__"))
      .def_property_readonly("name", [](const Loaded& loaded) { return loaded.scene.name; })
      .def_property_readonly("hash", [](const Loaded& loaded) { return SceneHash(loaded.scene); })
      .def_property_readonly(
          "tools", [](const Loaded& loaded) -> const auto& { return loaded.scene.tools; })
      .def_property_readonly(
          "objects", [](const Loaded& loaded) -> const auto& { return loaded.scene.objects; })
      .def_readonly("said", &Loaded::said)
      .def_property_readonly(
          "parameters", [](const Loaded& loaded) { return ToDict(ParametersOf(loaded.scene)); })
      .def("__repr__",
           [](const Loaded& loaded) {
             const Scene& scene = loaded.scene;
             return Shown("Scene", scene.name, ": tools ", NamesOf(scene.tools), "; objects ",
                          NamesOf(scene.objects));
           })
      .def(py::pickle(
          [](const Loaded& loaded) {
            return py::make_tuple(ToBytes(loaded.scene), loaded.script, loaded.said, loaded.source);
          },
          [](const py::tuple& state) {
            return Loaded{ToScene(py::bytes(state[0])), state[1].cast<std::string>(),
                          state[2].cast<std::vector<std::string>>(), state[3]};
          }))
      .def(
          "_save", [](const Loaded& loaded, const py::object& file) { Save(loaded, ToPath(file)); },
          py::arg("file"))
      .def_readwrite("_source", &Loaded::source)
      .def("path", &PathOf, py::arg("rate") = 1000.0, prose("Scene.path"))
      .def("model", &ModelOf, py::arg("tool") = 0, prose("Scene.model"));
  module.def(
      "load",
      [](const py::object& name, const std::optional<std::string>& contact,
         const std::optional<double>& tolerance_um,
         const std::string& unit) { return Load(ToPath(name), contact, tolerance_um, unit); },
      py::arg("name"), py::kw_only(), py::arg("contact") = py::none(),
      py::arg("tolerance_um") = py::none(), py::arg("unit") = "", prose("load"));
  module.def("parameters", &Table, prose("parameters"));
  module.def("fault_words", &FaultWords, py::arg("faults"), prose("fault_words"));
  module.def("_offer_programs", &OfferProgramFolder);
  module.def("_usable_cores", [] { return UsableCores(); });
}

}  // namespace palpate
