#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <unistd.h>

#include "client/python/arrays.h"
#include "client/python/live/live_session.h"
#include "client/python/live/live_station.h"
#include "client/python/signals.h"
#include "common/dds/topics.h"
#include "common/program/log.h"

// The module palpate._live, which palpate/live.py wraps; palpate/live.pyi documents each function.
// All waiting is done without Python's lock, and Ctrl-C ends it.  A forked child is told to use
// "spawn" by all but `close`.

namespace palpate {
namespace {

/// Waits without Python's lock, and checks now and then for Ctrl-C.
class Waiting {
 public:
  bool operator()(std::chrono::nanoseconds time) {
    std::this_thread::sleep_for(time);
    check_();
    return false;
  }

 private:
  SignalCheck check_;
};

/// Returns the result of a call that runs without Python's lock.
template <class Call>
auto Meanwhile(Call call) {
  const py::gil_scoped_release free;
  Waiting waiting;
  return call(waiting);
}

void RequireDomain(int domain) {
  if (domain < 0 || domain > dds::kMaxDomain) {
    throw Error("domain: must be 0 to " + std::to_string(dds::kMaxDomain));
  }
}

dds::Network ToNetwork(const std::string& interface, const std::vector<std::string>& peers,
                       const std::string& identity) {
  dds::Network network;
  network.interface = interface;
  network.peers = peers;
  network.identity = identity;
  return network;
}

double ToSeconds(double seconds, const char* what) {
  if (!(seconds > 0.0) || !(seconds < 1e6)) throw Error(std::string(what) + ": must be above 0");
  return seconds;
}

template <class Record>
py::array_t<Record> ToArray(const std::vector<Record>& records) {
  return py::array_t<Record>(static_cast<py::ssize_t>(records.size()), records.data());
}

/// Returns an array's only record, as numpy.void, or None.
template <class Record>
py::object ToRecord(const std::optional<Record>& record) {
  if (!record) return py::none();
  return py::object(py::array_t<Record>(1, &*record)[py::int_(0)]);
}

/// The process that first opened a station or a session: only it has the threads of DDS.
std::atomic<pid_t> owner{0};

bool IsForked() {
  const pid_t began = owner.load();
  return began != 0 && began != getpid();
}

/// Throws Error in a child that was forked after something was opened; it would wait for ever.
void RequireOwnThreads() {
  pid_t nobody = 0;
  owner.compare_exchange_strong(nobody, getpid());
  if (!IsForked()) return;
  throw Error(
      "palpate.live: was in use when this process was forked, and its threads are not here; start "
      "processes by multiprocessing.get_context(\"spawn\"), and open stations in them");
}

/// Returns a method that may be called in the process that opened the object only.
template <class T, class Result>
auto Here(Result (T::*method)()) {
  return [method](T& self) {
    RequireOwnThreads();
    return (self.*method)();
  };
}
template <class T, class Result>
auto Here(Result (T::*method)() const) {
  return [method](const T& self) {
    RequireOwnThreads();
    return (self.*method)();
  };
}

/// Deletes, without Python's lock, an object whose destructor waits for threads.
template <class T>
struct Unlocked {
  void operator()(T* object) const {
    if (IsForked()) return;
    const py::gil_scoped_release free;
    delete object;
  }
};
/// Does nothing in a forked child.
template <class T>
void CloseHere(T& opened) {
  if (IsForked()) return;
  const py::gil_scoped_release free;
  opened.Close();
}
template <class T>
using Held = std::unique_ptr<T, Unlocked<T>>;

Held<LiveStation> MakeStation(const std::string& scene, const std::string& name,
                              const std::string& tool, int domain, const std::string& interface,
                              const std::vector<std::string>& peers, const std::string& identity,
                              const std::string& transport, const std::optional<py::object>& start,
                              double max_force, double max_torque, bool local_model,
                              double patience) {
  RequireDomain(domain);
  LiveStationOptions options;
  options.link.station = name;
  options.link.scene = scene;
  options.link.tool = tool;
  options.link.domain = domain;
  options.link.transport = dds::ParseTransport(transport);
  options.link.network = ToNetwork(interface, peers, identity);
  options.link.patience_s = ToSeconds(patience, "patience");
  if (start) options.start = ToUnitPose(*start, "start");
  options.max_force_N = max_force;
  options.max_torque_Nm = max_torque;
  options.local_model = local_model;
  RequireOwnThreads();
  return Meanwhile([&](Waiting& wait) {
    return Held<LiveStation>(new LiveStation(std::move(options), std::ref(wait)));
  });
}

Held<LiveSession> MakeSession(int domain, const std::string& interface,
                              const std::vector<std::string>& peers, const std::string& identity,
                              const std::string& transport, bool wrenches) {
  RequireDomain(domain);
  const LiveSessionOptions options{domain, ToNetwork(interface, peers, identity),
                                   dds::ParseTransport(transport), wrenches};
  RequireOwnThreads();
  const py::gil_scoped_release free;
  return Held<LiveSession>(new LiveSession(options));
}

void DefineStation(py::module_& module) {
  py::class_<LiveStation, Held<LiveStation>>(module, "Station")
      .def(py::init(&MakeStation))
      .def("move",
           [](LiveStation& station, const py::object& pose, double seconds, double timeout) {
             RequireOwnThreads();
             const Pose X_WH = ToUnitPose(pose);
             return Meanwhile([&](Waiting& wait) {
               return station.Move(X_WH, seconds, timeout, std::ref(wait));
             });
           })
      .def("lead",
           [](LiveStation& station, const py::object& effect, double rate, double max_force,
              double max_torque) {
             RequireOwnThreads();
             HeldWrench held = ToHeld(effect, rate, max_force, max_torque);
             const Felt felt = station.felt();
             if (!effect.is_none()) {
               if (!felt.sees_tool) return;
               Ask(effect, felt.X_WH, felt.V_WH, felt.X_WG, held);
             }
             station.Lead(held);
           })
      .def_property_readonly("felt", Here(&LiveStation::felt))
      .def_property_readonly("phase", Here(&LiveStation::phase))
      .def_property_readonly("id", Here(&LiveStation::name))
      .def_property_readonly("scene", Here(&LiveStation::scene))
      .def_property_readonly("tool", Here(&LiveStation::tool))
      .def_property_readonly("counts",
                             [](const LiveStation& station) {
                               RequireOwnThreads();
                               const LiveStation::Counts counts = station.counts();
                               py::dict figures;
                               figures["sent"] = counts.sent;
                               figures["replies"] = counts.replies;
                               figures["lost"] = counts.lost;
                               return figures;
                             })
      .def("news", Here(&LiveStation::TakeNews))
      .def("close", &CloseHere<LiveStation>);
}

void DefineSession(py::module_& module) {
  py::class_<LiveSession, Held<LiveSession>>(module, "Session")
      .def(py::init(&MakeSession))
      .def("tools",
           [](LiveSession& session, double timeout) {
             RequireOwnThreads();
             return ToArray(Meanwhile(
                 [&](Waiting& wait) { return session.TakeTools(timeout, std::ref(wait)); }));
           })
      .def("wrenches",
           [](LiveSession& session, const std::string& station, double timeout) {
             RequireOwnThreads();
             return ToArray(Meanwhile([&](Waiting& wait) {
               return session.TakeWrenches(station, timeout, std::ref(wait));
             }));
           })
      .def("latest_tool",
           [](const LiveSession& session, const std::string& station) {
             RequireOwnThreads();
             return ToRecord(session.LatestTool(station));
           })
      .def("latest_wrench",
           [](const LiveSession& session, const std::string& station) {
             RequireOwnThreads();
             return ToRecord(session.LatestWrench(station));
           })
      .def_property_readonly("phases", Here(&LiveSession::phases))
      .def_property_readonly("dropped", Here(&LiveSession::dropped))
      .def("close", &CloseHere<LiveSession>);
}

}  // namespace

PYBIND11_MODULE(_live, module) {
  PYBIND11_NUMPY_DTYPE(ToolRecord, time_s, station, scene, tool_name, pose_sequence, hand, tool,
                       force_N, torque_Nm, step_time_s, contacts, faults, points, point);
  PYBIND11_NUMPY_DTYPE(WrenchRecord, time_s, pose_time_s, pose_sequence, answer, force_N, torque_Nm,
                       tool, step_time_s, contacts, faults);
  // All modules throw the same error type, palpate.Error.
  static py::object error = py::module_::import("palpate._physics").attr("Error");
  error.inc_ref();  // must outlive the interpreter, as the translator may
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& wrong) {
      PyErr_SetString(error.ptr(), wrong.what());
    }
  });
  py::register_exception<Silence>(module, "Silence", error);
  // Messages of DDS go to stderr.
  SetUpLog("palpate.live", "warn");

  py::class_<Felt>(module, "Felt")
      .def_property_readonly("force", [](const Felt& f) { return FromVec3(f.applied.force); })
      .def_property_readonly("torque", [](const Felt& f) { return FromVec3(f.applied.torque); })
      .def_property_readonly("wanted_force", [](const Felt& f) { return FromVec3(f.wanted.force); })
      .def_property_readonly("wanted_torque",
                             [](const Felt& f) { return FromVec3(f.wanted.torque); })
      .def_property_readonly("hand", [](const Felt& f) { return FromPose(f.X_WH); })
      .def_property_readonly("twist", [](const Felt& f) { return FromTwist(f.V_WH); })
      .def_property_readonly("tool", [](const Felt& f) -> py::object {
        if (!f.sees_tool) return py::none();
        return FromPose(f.X_WG);
      });
  DefineStation(module);
  DefineSession(module);
  module.def("is_forked", &IsForked);
  module.attr("tool_dtype") = py::dtype::of<ToolRecord>();
  module.attr("wrench_dtype") = py::dtype::of<WrenchRecord>();
}

}  // namespace palpate
