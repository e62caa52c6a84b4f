#include "client/python/batch.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "client/python/arrays.h"
#include "client/python/hand.h"
#include "client/python/model.h"
#include "client/python/signals.h"
#include "client/python/steps.h"
#include "client/python/workers.h"
#include "common/program/machine.h"

// Many proxies of one model that step together, for loops that are closed in Python.

namespace palpate {
namespace {

constexpr py::ssize_t kMostProxies = 1'000'000;

class Batch {
 public:
  Batch(Shared shared, py::ssize_t count, const py::object& start, int threads)
      : shared_(std::move(shared)), workers_(CheckedThreads(threads, count)) {
    hands_.resize(static_cast<std::size_t>(count));
    if (!start.is_none()) Make(ToStarts(start));
  }

  Steps Step(const py::object& actions, bool details, const std::string& on_bad) {
    const Doubles poses = ToPoses(actions, 2, "(proxies, 3) or (proxies, 7)", on_bad);
    RequireRows(poses);
    const Busy busy(stepping_);
    if (!hands_.back()) Make(ToStarts(actions));
    Steps steps({Size()}, shared_, details);
    const Rows rows(steps);
    const py::gil_scoped_release free;
    // Ctrl-C waits for this step, so that all have taken the same number; it takes milliseconds.
    workers_.Run(hands_.size(), [&](std::size_t i, std::size_t) {
      StageTimes times;
      const StepReport report = hands_[i]->Step(RowOf(poses, i), details ? &times : nullptr);
      rows.From(static_cast<py::ssize_t>(i)).Put(report, times);
    });
    return steps;
  }

  /// Starts those again that `mask` selects; all if it is None.
  void Restart(const py::object& start, const py::object& mask) {
    const Busy busy(stepping_);
    const Doubles poses = ToStarts(start);
    std::vector<bool> chosen(hands_.size(), true);
    if (!mask.is_none()) {
      const auto array = py::array_t<bool, py::array::c_style>::ensure(mask);
      if (!array || array.ndim() != 1 || array.shape(0) != Size() ||
          py::array::ensure(mask).dtype().kind() != 'b') {
        PyErr_Clear();
        throw Error("mask: must be an array of " + std::to_string(hands_.size()) +
                    " booleans, one for each proxy");
      }
      std::copy_n(array.data(), chosen.size(), chosen.begin());
    }
    if (!hands_.back()) return Make(poses);
    const py::gil_scoped_release free;
    workers_.Run(hands_.size(), [&](std::size_t i, std::size_t) {
      if (chosen[i]) hands_[i]->Restart(RowOf(poses, i));
    });
  }

  py::ssize_t Size() const { return static_cast<py::ssize_t>(hands_.size()); }
  int Threads() const { return workers_.threads(); }
  const Shared& shared() const { return shared_; }

 private:
  static int CheckedThreads(int threads, py::ssize_t count) {
    if (count < 1 || count > kMostProxies) throw Error("n: must be from 1 to 1000000 proxies");
    if (threads < 0) throw Error("threads: must be 0, for all cores, or more");
    return static_cast<int>(std::min<py::ssize_t>(threads == 0 ? UsableCores() : threads, count));
  }
  void Make(const Doubles& starts) {
    const py::gil_scoped_release free;
    std::vector<std::unique_ptr<Hand>> made(hands_.size());
    SignalCheck check;
    workers_.Run(
        made.size(),
        [&](std::size_t i, std::size_t thread) {
          if (thread == 0) check();
          made[i] = std::make_unique<Hand>(shared_, RowOf(starts, i));
        },
        [&] { check(); });
    hands_ = std::move(made);
  }
  void RequireRows(const Doubles& poses) const {
    RequireShape(poses.shape(0) == Size(), poses, "poses",
                 "a pose for each of the " + std::to_string(hands_.size()) + " proxies");
  }
  /// Poses at which hands may start: one for all, or one for each.
  Doubles ToStarts(const py::object& start) const {
    const Doubles given = ToDoubles(start, "pose");
    if (given.ndim() == 1) {
      ToCheckedPose(start);
      return given;
    }
    const Doubles poses = ToPoses(start, 2, "(3), (7), (proxies, 3) or (proxies, 7)");
    RequireRows(poses);
    for (std::size_t i = 0; i < hands_.size(); ++i) {
      if (!IsPose(RowOf(poses, i))) {
        throw Error("pose: row " + std::to_string(i) + " is not finite; give finite numbers");
      }
    }
    return poses;
  }
  static Pose RowOf(const Doubles& poses, std::size_t i) {
    const py::ssize_t width = poses.shape(poses.ndim() - 1);
    return ToPose(poses.data() + (poses.ndim() == 1 ? 0 : static_cast<py::ssize_t>(i) * width),
                  width);
  }

  Shared shared_;
  Workers workers_;
  std::vector<std::unique_ptr<Hand>> hands_;
  std::thread::id stepping_;  // guarded by Python's lock
};

}  // namespace

void DefineBatch(py::module_& module, const Prose& prose) {
  py::class_<Batch>(module, "Batch")
      .def(py::init<Shared, py::ssize_t, const py::object&, int>(), py::arg("model"), py::arg("n"),
           py::arg("pose") = py::none(), py::kw_only(), py::arg("threads") = 0,
           prose("Batch.__init__"))
      .def("step", &Batch::Step, py::arg("actions"), py::kw_only(), py::arg("details") = false,
           py::arg("on_bad_pose") = "fault", prose("Batch.step"))
      .def("restart", &Batch::Restart, py::arg("pose"), py::arg("mask") = py::none(),
           prose("Batch.restart"))
      .def("__len__", &Batch::Size)
      .def_property_readonly("threads", &Batch::Threads)
      .def("__repr__", [](const Batch& batch) {
        return Shown("Batch", batch.Size(), " proxies of ", batch.shared().tool);
      });
}

}  // namespace palpate
