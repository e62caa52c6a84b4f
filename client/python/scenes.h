#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "client/python/prose.h"
#include "server/library/scenes.h"

namespace palpate {

namespace py = pybind11;

/// @field script  the hand's script beside the scene's file; empty: none.
/// @field said    the assumptions and repairs, one sentence each.
/// @field source  what palpate/described.py made it of; None: nothing.
struct Loaded {
  Scene scene;
  std::string script;
  std::vector<std::string> said;
  py::object source = py::none();
};

ContactModel ToContact(const std::string& contact);
/// Makes a scene of bodies, with the features that follow from their materials, as for a
/// scene's file.
Scene ToScene(const std::vector<Body>& objects, const std::vector<Body>& tools,
              const std::string& contact);
/// Throws Error if a number is not one, or out of the parameter's range.
void SetParameters(Scene& scene, const py::dict& parameters);

/// The bytes that pickle stores or sends to other processes.
py::bytes ToBytes(const Scene& scene);
Scene ToScene(const py::bytes& bytes);

void DefineBodies(py::module_& module, const Prose& prose);
void DefineScenes(py::module_& module, const Prose& prose);

}  // namespace palpate
