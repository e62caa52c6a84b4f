#include <pybind11/pybind11.h>

#include "client/python/meshes.h"
#include "client/python/prose.h"
#include "client/python/scenes.h"
#include "client/python/steps.h"
#include "common/error.h"
#include "common/revision.h"

// The module palpate._physics; palpate/__init__.pyi documents each function, also for help().
// Arrays are NumPy's, of double; poses are rows of x y z, or of x y z and w x y z.

namespace palpate {

PYBIND11_MODULE(_physics, module) {
  py::register_exception<Error>(module, "Error", PyExc_ValueError);
  module.attr("__version__") = PALPATE_VERSION;
  module.attr("physics_revision") = kPhysicsRevision;
  const Prose prose;
  py::options help;
  help.disable_function_signatures();  // the stub's signatures say more: array shapes and results
  DefineMeshes(module);
  DefineBodies(module, prose);
  DefineScenes(module, prose);
  DefineReports(module);
  DefineModels(module, prose);
}

}  // namespace palpate
