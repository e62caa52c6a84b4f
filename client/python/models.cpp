#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/python/arrays.h"
#include "client/python/batch.h"
#include "client/python/hand.h"
#include "client/python/model.h"
#include "client/python/scenes.h"
#include "client/python/signals.h"
#include "client/python/states.h"
#include "client/python/steps.h"
#include "client/python/workers.h"
#include "common/program/machine.h"
#include "common/revision.h"
#include "scenes/files/scene_bundle.h"

// Models, and proxies that step.

namespace palpate {

Shared Share(Scene scene, std::size_t tool) {
  const py::gil_scoped_release free;
  const auto kept = std::make_shared<const Scene>(std::move(scene));
  const Body& body = kept->tools[tool];
  return {std::make_shared<const HapticModel>(MakeModel(*kept, body, MakeObjects(*kept))),
          kept->name,
          body.name,
          std::make_shared<const std::vector<Parameter>>(ParametersOf(*kept)),
          kept,
          tool};
}

py::dict ToDict(const std::vector<Parameter>& parameters) {
  py::dict values;
  for (const Parameter& parameter : parameters) values[parameter.name] = parameter.value;
  return values;
}

Used FromDict(const py::dict& values) {
  std::vector<Parameter> parameters = ParametersOf(Scene{});
  for (Parameter& p : parameters) p.value = values[p.name].cast<double>();
  return std::make_shared<const std::vector<Parameter>>(std::move(parameters));
}

namespace {

/// Hands what was done before an exception to whoever catches it.
void Attach(py::error_already_set& error, const Steps& steps) {
  error.value().attr("steps") = steps;
}

/// @param ends  called before each step: whether to return early; may throw.
/// @param done  counts the steps.
template <class Ends>
void Walk(Hand& hand, const double* poses, py::ssize_t count, py::ssize_t width, Rows out,
          py::ssize_t& done, Ends ends) {
  for (py::ssize_t i = 0; i < count && !ends(); ++i, ++done) {
    StageTimes times;
    const StepReport report =
        hand.Step(ToPose(poses + i * width, width), out.details ? &times : nullptr);
    out.From(i).Put(report, times);
  }
}

}  // namespace

/// Throws Error if a quaternion is not of length 1.  A pose that is not finite is the step's fault.
static void RequireUnit(const Pose& X, std::ptrdiff_t row) {
  if (IsPose(X) || !X.p.allFinite() || !X.q.coeffs().allFinite()) return;
  throw Error("poses: row " + std::to_string(row) + " has a quaternion of length " +
              std::to_string(X.q.norm()) +
              "; w x y z must have 1, and palpate.pose takes other orders");
}

Doubles ToPoses(const py::object& given, py::ssize_t dimensions, const char* shape,
                const std::string& on_bad) {
  if (on_bad != "fault" && on_bad != "raise") {
    throw Error("on_bad_pose: '" + on_bad + "' is not known; give 'fault' or 'raise'");
  }
  Doubles poses = ToDoubles(given, "poses");
  const py::ssize_t width = poses.ndim() > 0 ? poses.shape(poses.ndim() - 1) : 0;
  RequireShape(poses.ndim() == dimensions && (width == 3 || width == 7), poses, "poses",
               std::string("an array ") + shape);
  for (const double* row = poses.data(); row < poses.data() + poses.size(); row += width) {
    const std::ptrdiff_t number = (row - poses.data()) / width;
    RequireUnit(ToPose(row, width), number);
    if (on_bad == "raise" && !IsPose(ToPose(row, width))) {
      throw Error("poses: row " + std::to_string(number) +
                  " is not finite; leave it out, or give on_bad_pose='fault'");
    }
  }
  return poses;
}

namespace {

/// Converts the pose of one step.  What nearly all programs give is read as it is: an array of
/// doubles, or a list or tuple of Python's floats.  The general way takes a third of a step.
Pose ToPoseOfStep(const py::object& given) {
  double row[7];
  py::ssize_t width = 0;
  if (const double* const numbers = PlainDoubles(given, width)) {
    std::copy_n(numbers, std::min<py::ssize_t>(width, 7), row);
  } else {
    width = PlainFloats(given, row);
  }
  if (width != 3 && width != 7) {
    const Doubles array = ToPoses(given, 1, "(3) or (7)");
    return ToPose(array.data(), array.size());
  }
  const Pose X = ToPose(row, width);
  RequireUnit(X, 0);
  return X;
}

void SetEffect(Hand& hand, const py::object& effect, double rate_Hz, double max_force_N,
               double max_torque_Nm) {
  const HeldWrench held = ToHeld(effect, rate_Hz, max_force_N, max_torque_Nm);
  const Busy busy(hand.stepping);
  hand.effect.reset();
  if (!effect.is_none()) hand.effect = SlowEffect{effect, {held, {}}};
}

Steps StepAll(Hand& hand, const py::object& given, bool details, const std::string& on_bad) {
  const Doubles poses = ToPoses(given, 2, "(steps, 3) or (steps, 7)", on_bad);
  const Busy busy(hand.stepping);
  Steps steps({poses.shape(0)}, hand.shared, details);
  const Rows rows(steps);
  py::ssize_t done = 0;
  try {
    const py::gil_scoped_release free;
    SignalCheck check;
    Walk(hand, poses.data(), poses.shape(0), poses.shape(1), rows, done, [&] {
      check();
      return false;
    });
  } catch (py::error_already_set& error) {
    Attach(error, steps.At(py::slice(0, done, 1)));
    throw;
  }
  return steps;
}

/// Follows each path with a proxy of its own, which starts at the path's first pose.
/// @param done  for each path, the number of its steps that were taken.
void WalkAll(const Shared& shared, const Doubles& paths, int threads, const Rows& all,
             std::vector<py::ssize_t>& done) {
  const py::ssize_t count = paths.shape(0), length = paths.shape(1), width = paths.shape(2);
  const double* const data = paths.data();
  const py::gil_scoped_release free;
  SignalCheck check;
  Workers workers(
      static_cast<int>(std::min<py::ssize_t>(threads == 0 ? UsableCores() : threads, count)));
  std::vector<std::optional<Hand>> hands(static_cast<std::size_t>(workers.threads()));
  const auto follow = [&](std::size_t path, std::size_t thread) {
    const auto first = static_cast<py::ssize_t>(path) * length;
    const double* const poses = data + first * width;
    const Pose start = ToPose(poses, width);
    std::optional<Hand>& hand = hands[thread];
    // A tool that cuts gets a new proxy for each path, so that every path meets the whole solid,
    // whichever thread follows it.
    if (hand && !shared.model->cuts()) {
      hand->Restart(start);
    } else {
      hand.emplace(shared, start);
    }
    Walk(*hand, poses, length, width, all.From(first), done[path], [&] {
      if (thread == 0) check();
      return workers.has_failed();
    });
  };
  workers.Run(static_cast<std::size_t>(count), follow, [&] { check(); });
}

Steps FollowAll(const Shared& shared, const py::object& given, int threads, bool details,
                const std::string& on_bad) {
  const Doubles paths = ToPoses(given, 3, "(paths, steps, 3) or (paths, steps, 7)", on_bad);
  if (threads < 0) throw Error("threads: must be 0, for all cores, or more");
  const py::ssize_t count = paths.shape(0), length = paths.shape(1);
  Steps steps({count, length}, shared, details);
  const Rows all(steps);
  if (count == 0 || length == 0) return steps;
  std::vector<py::ssize_t> done(static_cast<std::size_t>(count));
  try {
    WalkAll(shared, paths, threads, all, done);
  } catch (py::error_already_set& error) {
    for (py::ssize_t path = 0; path < count; ++path) {
      const py::ssize_t taken = done[static_cast<std::size_t>(path)];
      all.From(path * length + taken).Blank(length - taken);
    }
    Attach(error, steps);
    throw;
  }
  return steps;
}

Shared MakeShared(const std::vector<Body>& objects, const Body& tool, const std::string& contact,
                  const py::kwargs& parameters) {
  Scene scene = ToScene(objects, {tool}, contact);
  scene.name = "scene";
  CheckPackable(scene);  // as Scene and scene files are checked
  SetParameters(scene, parameters);
  return Share(std::move(scene), 0);
}

/// Lets Python find circles of references through a proxy's effect, which often refers to the
/// proxy, and collect them.
void CollectCircles(PyHeapTypeObject* heap_type) {
  PyTypeObject& type = heap_type->ht_type;
  static const destructor destroy = type.tp_base->tp_dealloc;
  // Null before its constructor has run.
  static const auto hand_of = [](PyObject* self) {
    return static_cast<Hand*>(
        reinterpret_cast<py::detail::instance*>(self)->get_value_and_holder().value_ptr());
  };
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    const Hand* const hand = hand_of(self);
    if (hand != nullptr && hand->effect) Py_VISIT(hand->effect->ask.ptr());
    Py_VISIT(Py_TYPE(self));
    return 0;
  };
  type.tp_clear = [](PyObject* self) {
    Hand* const hand = hand_of(self);
    std::optional<SlowEffect> gone;  // ended last, since that may run Python's code
    if (hand != nullptr) std::swap(gone, hand->effect);
    return 0;
  };
  // pybind11 2.10 leaves it in the collector's list while it is destroyed.
  type.tp_dealloc = [](PyObject* self) {
    PyObject_GC_UnTrack(self);
    destroy(self);
  };
}

}  // namespace

void DefineModels(py::module_& module, const Prose& prose) {
  py::class_<Shared> model(module, "Model");
  model
      .def(py::init(&MakeShared), py::arg("objects"), py::arg("tool"), py::kw_only(),
           py::arg("contact") = "surface", prose("Model.__init__"))
      .def_property_readonly("parameters",
                             [](const Shared& shared) { return ToDict(*shared.parameters); })
      .def("__repr__",
           [](const Shared& shared) {
             std::ostringstream text;
             for (const Parameter& p : *shared.parameters) text << ", " << p.name << "=" << p.value;
             return Shown("Model", "of ", shared.tool, " in ",
                          shared.scene.empty() ? "a scene" : shared.scene, text.str());
           })
      .def("follow", &FollowAll, py::arg("paths"), py::kw_only(), py::arg("threads") = 0,
           py::arg("details") = false, py::arg("on_bad_pose") = "fault", prose("Model.follow"))
      .def("__copy__", [](const py::object& self) { return self; })
      .def("__deepcopy__", [](const py::object& self, const py::object&) { return self; })
      .def(py::pickle(
          [](const Shared& shared) {
            if (!shared.made_of->effects.empty()) {
              throw Error(
                  "pickle: the Model has effects in C, whose code a pickle cannot hold; load its "
                  "scene there");
            }
            return py::make_tuple(kPhysicsRevision, ToBytes(*shared.made_of), shared.tool_index);
          },
          [](const py::tuple& stored) {
            if (stored.size() != 3) throw Error("pickle: the Model is damaged; store it again");
            RequireRevision(stored[0], "Model");
            Scene scene = ToScene(py::bytes(stored[1]));
            const auto tool = stored[2].cast<std::size_t>();
            if (tool >= scene.tools.size()) {
              throw Error("pickle: the Model is damaged; store it again");
            }
            return Share(std::move(scene), tool);
          }));

  py::class_<Hand> proxy(module, "Proxy", py::custom_type_setup(&CollectCircles));
  proxy
      .def(py::init([](const Shared& shared, const py::object& pose) {
             return std::make_unique<Hand>(shared, ToCheckedPose(pose));
           }),
           py::arg("model"), py::arg("pose"), prose("Proxy.__init__"))
      .def_property_readonly("start_depth",
                             [](const Hand& hand) { return hand.proxy.start_depth(); })
      .def_property_readonly(
          "moved",
          [](const Hand& hand) {
            py::dict poses;
            const auto groups = hand.proxy.model().moved();
            for (std::size_t i = 0; i < groups.size(); ++i) {
              poses[py::str(groups[i].name)] = FromPose(hand.proxy.X_moved(i));
            }
            return poses;
          },
          prose("Proxy.moved"))
      .def(
          "restart",
          [](Hand& hand, const py::object& pose) {
            const Pose X_WH = ToCheckedPose(pose);
            const Busy busy(hand.stepping);
            hand.Restart(X_WH);
          },
          py::arg("pose"), prose("Proxy.restart"))
      .def(
          "step",
          [](Hand& hand, const py::object& pose) {
            const Pose X_WH = ToPoseOfStep(pose);
            const Busy busy(hand.stepping);
            const py::gil_scoped_release free;
            auto report = std::make_unique<Report>();
            report->parameters = hand.shared.parameters;
            ToRecord(hand.Step(X_WH), {}, report->record);
            return report;
          },
          py::arg("pose"), prose("Proxy.step"))
      .def("set_effect", &SetEffect, py::arg("effect"), py::kw_only(), py::arg("rate_hz") = 100.0,
           py::arg("max_force") = HeldWrench{}.max_force_N,
           py::arg("max_torque") = HeldWrench{}.max_torque_Nm, prose("Proxy.set_effect"))
      .def("steps", &StepAll, py::arg("poses"), py::kw_only(), py::arg("details") = false,
           py::arg("on_bad_pose") = "fault", prose("Proxy.steps"))
      .def("__repr__", [](const Hand& hand) { return Shown("Proxy", "of ", hand.shared.tool); });
  DefineStates(module, proxy, prose);
  DefineBatch(module, prose);
}

}  // namespace palpate
