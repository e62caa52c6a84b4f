#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/python/arrays.h"
#include "client/python/report_record.h"
#include "common/files/project_files.h"
#include "scenes/files/scene_bundle.h"
#include "server/library/scenes.h"

// The module palpate._physics; palpate/__init__.pyi documents each function, also for help().
// Arrays are NumPy's, of double; poses are rows of x y z, or of x y z and w x y z.

namespace palpate {
namespace {

Vec3 ToVec3(const py::object& given, const char* what) {
  const Doubles array = ToDoubles(given, what);
  RequireShape(array.ndim() == 1 && array.shape(0) == 3, array, what, "three numbers");
  return Vec3::Map(array.data());
}

/// Converts an integer of any type; MakeBody checks that it is a valid vertex index.
std::uint32_t ToIndex(double index) {
  if (!(index >= 0.0 && index <= std::numeric_limits<std::uint32_t>::max()) ||
      index != std::floor(index)) {
    throw Error("triangles: " + py::str(py::float_(index)).cast<std::string>() +
                " is not a vertex; give whole numbers from 0");
  }
  return static_cast<std::uint32_t>(index);
}

TriangleMesh ToMesh(const py::object& given_vertices, const py::object& given_triangles) {
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

ContactModel ToContact(const std::string& contact) {
  if (contact == "surface") return ContactModel::kSurface;
  if (contact == "spheres") return ContactModel::kSpheres;
  throw Error("contact: '" + contact + "' is not known; give 'surface' or 'spheres'");
}

/// The parameters that something was made with.
using Used = std::shared_ptr<const std::vector<Parameter>>;

/// A model and the parameters that it was made with; proxies keep it alive.
struct Shared {
  std::shared_ptr<const HapticModel> model;
  std::string scene, tool;
  Used parameters;
};

Shared Share(const Scene& scene, const Body& tool) {
  const py::gil_scoped_release free;
  return {std::make_shared<const HapticModel>(MakeModel(scene, tool, MakeObjects(scene))),
          scene.name, tool.name,
          std::make_shared<const std::vector<Parameter>>(ParametersOf(scene))};
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

/// @field script  the hand's script beside the scene's file; empty: none.
/// @field said    the assumptions and repairs, one sentence each.
struct Loaded {
  Scene scene;
  std::string script;
  std::vector<std::string> said;
};

/// Makes a scene of bodies, with the features that follow from their materials, as for a
/// scene's file.
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

void SetParameters(Scene& scene, const py::kwargs& parameters) {
  for (const auto& [name, value] : parameters) {
    const auto what = name.cast<std::string>();
    // Python's float() would read text, too.
    const Doubles number = ToDoubles(py::reinterpret_borrow<py::object>(value), what);
    RequireShape(number.ndim() == 0, number, what, "a single number");
    SetParameter(scene, what, *number.data());
  }
}

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
  options.progress = [&](std::string_view stage, double done) {
    line(stage, done);
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
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
    if (which.equal(py::int_(i)) || which.equal(py::str(tool.name))) return Share(scene, tool);
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

/// A force in Python attached to a proxy: called once every few steps, held in between.
struct SlowEffect {
  py::object ask;
  HeldWrench held;
  EffectState motion{};  // of the hand, with the number of its steps
};

struct Hand {
  Hand(Shared m, const Pose& X_WH) : shared(std::move(m)), proxy(*shared.model, X_WH) {}

  void Restart(const Pose& X_WH) {
    proxy.Restart(X_WH);
    if (effect) effect->motion = {};
  }
  /// Takes a step, without Python's lock except while it calls an effect.  If the effect raises,
  /// throws that, switches the effect off, and takes no step.
  StepReport Step(const Pose& X_WH, StageTimes* times = nullptr) {
    const bool acts = effect && IsPose(X_WH);
    if (acts) LookAt(X_WH);
    StepReport report = proxy.Step(X_WH, times);
    if (!acts) return report;
    const Pose& X = effect->motion.X_WH;
    Wrench given = effect->held.At(X);
    given.torque -= (X.q * shared.model->reference()).cross(given.force);
    for (Wrench* sum : {&report.wrench, &report.effects.active}) {
      *sum = {sum->force + given.force, sum->torque + given.torque};
    }
    return report;
  }

  Shared shared;  // declared first: outlives the proxy
  Proxy proxy;
  std::optional<SlowEffect> effect{};
  std::atomic_flag busy{};

 private:
  void LookAt(const Pose& X_WH) {
    auto& [ask, held, motion] = *effect;
    Follow({X_WH.p, X_WH.q.normalized()}, motion);
    if (motion.cycle++ % held.every != 0) return;
    const py::gil_scoped_acquire lock;
    try {
      Ask(ask, motion.X_WH, motion.V_WH, proxy.X_WG(), held);
    } catch (...) {
      effect.reset();
      throw;
    }
  }
};

/// Prevents other threads from stepping a hand while its step has released Python's lock.
class Busy {
 public:
  explicit Busy(Hand& hand) : hand_(hand) {
    if (hand.busy.test_and_set(std::memory_order_acquire)) {
      throw Error("proxy: another thread is stepping it; give each thread a proxy of its own");
    }
  }
  ~Busy() { hand_.busy.clear(std::memory_order_release); }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  Hand& hand_;
};

/// The result of one step.
struct Report {
  ReportRecord record;
  Used parameters;
};

/// The results of a path of poses, one row per step.
struct Steps {
  using Records = py::array_t<ReportRecord>;
  Steps() = default;
  Steps(const std::vector<py::ssize_t>& leading, const Shared& shared, bool detailed)
      : wrench(With(leading, 6)),
        pose(With(leading, 7)),
        contacts(leading),
        faults(leading),
        details(detailed ? py::object(Records(leading)) : py::none()),
        parameters(ToDict(*shared.parameters)) {}
  static std::vector<py::ssize_t> With(std::vector<py::ssize_t> shape, py::ssize_t last) {
    shape.push_back(last);
    return shape;
  }
  py::array_t<double> wrench, pose;
  py::array_t<std::int32_t> contacts;
  py::array_t<std::uint32_t> faults;
  py::object details;  // Records, or None
  py::dict parameters;
};

/// Where to write the steps of one path.
struct Rows {
  explicit Rows(Steps& steps)
      : wrench(steps.wrench.mutable_data()),
        pose(steps.pose.mutable_data()),
        contacts(steps.contacts.mutable_data()),
        faults(steps.faults.mutable_data()),
        details(steps.details.is_none() ? nullptr : Steps::Records(steps.details).mutable_data()) {}
  /// Returns the rows from that step on.
  Rows From(py::ssize_t step) const {
    Rows rows = *this;
    rows.wrench += 6 * step;
    rows.pose += 7 * step;
    rows.contacts += step;
    rows.faults += step;
    if (details) rows.details += step;
    return rows;
  }
  double *wrench, *pose;
  std::int32_t* contacts;
  std::uint32_t* faults;
  ReportRecord* details;  // may be null
};

void Walk(Hand& hand, const double* poses, py::ssize_t count, py::ssize_t width, Rows out) {
  for (py::ssize_t i = 0; i < count; ++i) {
    StageTimes times;
    const StepReport report =
        hand.Step(ToPose(poses + i * width, width), out.details ? &times : nullptr);
    Vec3::Map(out.wrench + 6 * i) = report.wrench.force;
    Vec3::Map(out.wrench + 6 * i + 3) = report.wrench.torque;
    FromPose(report.X_WG, out.pose + 7 * i);
    out.contacts[i] = Contacts(report);
    out.faults[i] = report.faults;
    if (out.details) out.details[i] = ToRecord(report, times);
  }
}

/// Converts an array to poses.  A row that is not finite becomes a fault of its step; a quaternion
/// of another length is an error.
Doubles ToPoses(const py::object& given, py::ssize_t dimensions, const char* shape) {
  Doubles poses = ToDoubles(given, "poses");
  const py::ssize_t width = poses.ndim() > 0 ? poses.shape(poses.ndim() - 1) : 0;
  RequireShape(poses.ndim() == dimensions && (width == 3 || width == 7), poses, "poses",
               std::string("an array ") + shape);
  for (const double* row = poses.data(); row < poses.data() + poses.size(); row += width) {
    const Pose X = ToPose(row, width);
    if (X.p.allFinite() && X.q.coeffs().allFinite() && !IsPose(X)) {
      throw Error("poses: row " + std::to_string((row - poses.data()) / width) +
                  " has a quaternion of length " + std::to_string(X.q.norm()) + "; it must be 1");
    }
  }
  return poses;
}

void SetEffect(Hand& hand, const py::object& effect, double rate_Hz, double max_force_N,
               double max_torque_Nm) {
  const HeldWrench held = ToHeld(effect, rate_Hz, max_force_N, max_torque_Nm);
  const Busy busy(hand);
  hand.effect.reset();
  if (!effect.is_none()) hand.effect = SlowEffect{effect, held};
}

Steps StepAll(Hand& hand, const py::object& given, bool details) {
  const Doubles poses = ToPoses(given, 2, "(steps, 3) or (steps, 7)");
  const Busy busy(hand);
  Steps steps({poses.shape(0)}, hand.shared, details);
  const Rows rows(steps);
  const py::gil_scoped_release free;
  Walk(hand, poses.data(), poses.shape(0), poses.shape(1), rows);
  return steps;
}

/// Follows each path with a proxy of its own, which starts at the path's first pose.
Steps FollowAll(const Shared& shared, const py::object& given, int threads, bool details) {
  const Doubles paths = ToPoses(given, 3, "(paths, steps, 3) or (paths, steps, 7)");
  if (threads < 0) throw Error("threads: must be 0, for all cores, or more");
  const py::ssize_t count = paths.shape(0), length = paths.shape(1), width = paths.shape(2);
  Steps steps({count, length}, shared, details);
  const Rows all(steps);
  if (count == 0 || length == 0) return steps;
  const double* data = paths.data();
  const py::gil_scoped_release free;
  std::atomic<py::ssize_t> next{0};
  std::exception_ptr wrong;
  std::mutex wrong_mutex;
  const auto work = [&] {
    try {
      std::optional<Hand> hand;
      for (py::ssize_t path; (path = next.fetch_add(1)) < count;) {
        const double* poses = data + path * length * width;
        const Pose start = ToPose(poses, width);
        // A tool that cuts gets a new proxy for each path, so that every path meets the whole
        // solid, whichever thread follows it.
        if (hand && !shared.model->cuts()) {
          hand->Restart(start);
        } else {
          hand.emplace(shared, start);
        }
        Walk(*hand, poses, length, width, all.From(path * length));
      }
    } catch (...) {
      const std::lock_guard lock(wrong_mutex);
      wrong = std::current_exception();
    }
  };
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  const auto wanted = static_cast<py::ssize_t>(threads == 0 ? cores : unsigned(threads));
  std::vector<std::jthread> others;
  for (py::ssize_t i = 1; i < std::min(wanted, count); ++i) others.emplace_back(work);
  work();
  others.clear();
  if (wrong) std::rethrow_exception(wrong);
  return steps;
}

Material ToMaterial(double static_friction, double dynamic_friction, double stiffness) {
  if (!(static_friction >= dynamic_friction && dynamic_friction >= 0.0)) {
    throw Error("friction: must be 0 <= dynamic_friction <= static_friction");
  }
  if (!(stiffness > 0.0)) throw Error("stiffness must be above 0; infinite: rigid");
  return {stiffness, static_friction, dynamic_friction};
}

Shared MakeShared(const std::vector<Body>& objects, const Body& tool, const std::string& contact,
                  double stiffness, double torsional_stiffness,
                  const std::map<std::string, double>& step) {
  Scene scene = ToScene(objects, {tool}, contact);
  scene.coupling = {stiffness, torsional_stiffness};
  for (const auto& [field, value] : step) SetParameter(scene, field, value);
  return Share(scene, scene.tools[0]);
}

/// The texts that help() shows for functions, from the stub.
class Prose {
 public:
  Prose() : texts_(py::module_::import("palpate._prose").attr("read")("__init__.pyi")) {}
  /// Returns a text, valid while this object lives.  Throws for a name that the stub does not have.
  const char* operator()(const char* name) const {
    const char* text = PyUnicode_AsUTF8(texts_[name].ptr());
    if (!text) throw py::error_already_set();
    return text;
  }

 private:
  py::dict texts_;
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Formats a Python repr: "<palpate.Body tooth: ...>".
template <class... Parts>
std::string Shown(const char* kind, const Parts&... parts) {
  std::ostringstream text;
  text << "<palpate." << kind << ' ';
  (text << ... << parts);
  return text.str() + ">";
}
std::string Row(const double* x, int count) {
  std::ostringstream text;
  for (int i = 0; i < count; ++i) text << (i > 0 ? " " : "[") << x[i];
  return text.str() + "]";
}

/// Makes pickling a class an error that says why: its objects hold the state of a running hand, or
/// are quickly made anew.
template <class Class>
void RefusePickle(Class& of, const char* why) {
  of.def("__reduce__",
         [why](const typename Class::type&) -> py::object { throw py::type_error(why); });
}

template <class Record>
py::object ToVoid(const Record& record) {
  return py::array_t<Record>(1, &record)[py::int_(0)];
}

Report ToReport(const py::bytes& bytes, const py::dict& parameters) {
  Report report{{}, FromDict(parameters)};
  const auto text = std::string_view(bytes);
  if (text.size() != sizeof report.record)
    throw Error(
        "pickle: the Report is from another version of palpate; make it again with this one");
  std::memcpy(&report.record, text.data(), text.size());
  return report;
}

py::array_t<double> PointsOf(const ReportRecord& r) {
  py::array_t<double> points({py::ssize_t{r.listed}, py::ssize_t{6}});
  for (int i = 0; i < r.listed; ++i) {
    const RowRecord& row = r.rows[i];
    double* out = points.mutable_data(i, 0);
    Vec3::Map(out) = Vec3::Map(row.point_m);
    Vec3::Map(out + 3) = row.force_N * Vec3::Map(row.normal) + Vec3::Map(row.friction_N);
  }
  return points;
}

void DefineReports(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(RowRecord, body, tool_part, object_part, row, object_leaf, point_m, normal,
                       lever_cross_normal_m, offset_m, force_N, friction_N, stiffness_N_per_m,
                       static_friction, dynamic_friction);
  PYBIND11_NUMPY_DTYPE(ReportRecord, force_N, torque_Nm, tool, soft_force_N, soft_torque_Nm,
                       bur_force_N, bur_m, faults, contacts, soft_contacts, listed, substeps,
                       predicted_pairs, qp_iterations, friction_iterations, friction_lowered,
                       friction_unsolved, friction_resets, truncation_m, prediction_ns, rows_ns,
                       solve_ns, response_ns, rows);
  module.attr("report_dtype") = py::dtype::of<ReportRecord>();
  py::class_<Report>(module, "Report")
      .def_property_readonly("force",
                             [](const Report& r) { return FromNumbers(r.record.force_N, 3); })
      .def_property_readonly("torque",
                             [](const Report& r) { return FromNumbers(r.record.torque_Nm, 3); })
      .def_property_readonly("pose", [](const Report& r) { return FromNumbers(r.record.tool, 7); })
      .def_property_readonly("contacts", [](const Report& r) { return r.record.contacts; })
      .def_property_readonly("points", [](const Report& r) { return PointsOf(r.record); })
      .def_property_readonly(
          "rows",
          [](const Report& r) { return py::array_t<RowRecord>(r.record.listed, r.record.rows); })
      .def_property_readonly("details", [](const Report& r) { return ToVoid(r.record); })
      .def_property_readonly("faults", [](const Report& r) { return r.record.faults; })
      .def_property_readonly("substeps", [](const Report& r) { return r.record.substeps; })
      .def_property_readonly("parameters", [](const Report& r) { return ToDict(*r.parameters); })
      .def("__repr__",
           [](const Report& r) {
             return Shown("Report", "force ", Row(r.record.force_N, 3), " N, torque ",
                          Row(r.record.torque_Nm, 3), " N m, contacts ", r.record.contacts,
                          ", faults ", FaultWords(r.record.faults));
           })
      .def(py::pickle(
          [](const Report& r) {
            return py::make_tuple(
                py::bytes(reinterpret_cast<const char*>(&r.record), sizeof r.record),
                ToDict(*r.parameters));
          },
          [](const py::tuple& state) { return ToReport(state[0], state[1]); }));
  py::class_<Steps>(module, "Steps")
      .def_readonly("wrench", &Steps::wrench)
      .def_readonly("pose", &Steps::pose)
      .def_readonly("contacts", &Steps::contacts)
      .def_readonly("faults", &Steps::faults)
      .def_readonly("details", &Steps::details)
      .def_readonly("parameters", &Steps::parameters)
      .def("__len__",
           [](const Steps& s) {
             if (s.contacts.ndim() == 0) throw py::type_error("a single step has no length");
             return s.contacts.shape(0);
           })
      .def("__iter__",
           [](const py::object& steps) {
             return py::reinterpret_steal<py::object>(PySeqIter_New(steps.ptr()));
           })
      // As of an array whose rows are steps: an index, a slice or a mask of them, or a tuple for
      // paths and steps.  An index beyond the end raises IndexError, which ends iteration.
      .def("__getitem__",
           [](const Steps& s, const py::object& at) {
             const auto taken = [&at](const py::object& array) -> py::object {
               return array.attr("__getitem__")(at);
             };
             Steps part;
             part.contacts = taken(s.contacts);
             part.faults = taken(s.faults);
             part.wrench = taken(s.wrench);
             part.pose = taken(s.pose);
             part.details = s.details.is_none() ? s.details : taken(s.details);
             part.parameters = s.parameters;
             // An index of axes, as [..., 0], takes other numbers of each array.
             const auto holds = [&rows = part.contacts](const py::array& array, int numbers) {
               const py::ssize_t n = rows.ndim();
               return array.ndim() == n + 1 && array.shape(n) == numbers &&
                      std::equal(rows.shape(), rows.shape() + n, array.shape());
             };
             if (!holds(part.wrench, 6) || !holds(part.pose, 7)) {
               throw Error("steps: an index chooses paths and steps; for axes, index steps.wrench");
             }
             return part;
           })
      .def("__repr__",
           [](const Steps& steps) {
             if (steps.contacts.ndim() == 0) {
               const Doubles one(steps.wrench);
               const double* const wrench = one.data();
               return Shown("Steps", "one step: force ", Row(wrench, 3), " N, torque ",
                            Row(wrench + 3, 3), " N m, contacts ", *steps.contacts.data(),
                            ", faults ", FaultWords(*steps.faults.data()));
             }
             const auto shape = py::str(steps.contacts.attr("shape")).cast<std::string>();
             const std::int32_t* const c = steps.contacts.data();
             const std::uint32_t* const f = steps.faults.data();
             std::uint32_t faults = 0;
             for (py::ssize_t i = 0; i < steps.faults.size(); ++i) faults |= f[i];
             const auto touch =
                 std::count_if(c, c + steps.contacts.size(), [](int n) { return n > 0; });
             return Shown("Steps", "of shape ", shape, ": ", touch, " in contact, faults ",
                          FaultWords(faults));
           })
      .def(py::pickle(
          [](const Steps& s) {
            return py::make_tuple(s.wrench, s.pose, s.contacts, s.faults, s.details, s.parameters);
          },
          [](const py::tuple& state) {
            Steps s;
            const auto take = [&](auto& field, int i) {
              field = state[i].cast<std::remove_reference_t<decltype(field)>>();
            };
            take(s.wrench, 0);
            take(s.pose, 1);
            take(s.contacts, 2);
            take(s.faults, 3);
            take(s.details, 4);
            take(s.parameters, 5);
            return s;
          }));
}

}  // namespace

PYBIND11_MODULE(_physics, module) {
  py::register_exception<Error>(module, "Error", PyExc_ValueError);
  module.attr("__version__") = PALPATE_VERSION;
  const Prose prose;
  py::options help;
  help.disable_function_signatures();  // the stub's signatures say more: array shapes and results

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
            alone.name = "body";
            return ToBytes(alone);
          },
          [](const py::bytes& state) { return std::move(ToScene(state).objects[0]); }));

  module.def(
      "body",
      [](const std::string& name, const py::object& vertices, const py::object& triangles,
         std::size_t leaves, const std::string& contact, double static_friction,
         double dynamic_friction, double stiffness) {
        TriangleMesh mesh = ToMesh(vertices, triangles);
        const BodyOptions options{
            .leaves = leaves,
            .contact = ToContact(contact),
            .material = ToMaterial(static_friction, dynamic_friction, stiffness)};
        Body body;
        {
          const py::gil_scoped_release free;
          body = MakeBody(name, std::move(mesh), options);
        }
        WarnOfUnit(body);
        return body;
      },
      py::arg("name"), py::arg("vertices"), py::arg("triangles"), py::kw_only(),
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
            return py::make_tuple(ToBytes(loaded.scene), loaded.script, loaded.said);
          },
          [](const py::tuple& state) {
            return Loaded{ToScene(py::bytes(state[0])), state[1].cast<std::string>(),
                          state[2].cast<std::vector<std::string>>()};
          }))
      .def(
          "save", [](const Loaded& loaded, const py::object& file) { Save(loaded, ToPath(file)); },
          py::arg("file"), prose("Scene.save"))
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
  DefineReports(module);

  py::class_<Shared> model(module, "Model");
  model
      .def(py::init([](const std::vector<Body>& objects, const Body& tool,
                       const std::string& contact, double stiffness, double torsional_stiffness,
                       const std::map<std::string, double>& step) {
             return MakeShared(objects, tool, contact, stiffness, torsional_stiffness, step);
           }),
           py::arg("objects"), py::arg("tool"), py::kw_only(), py::arg("contact") = "surface",
           py::arg("stiffness") = Coupling{}.stiffness,
           py::arg("torsional_stiffness") = Coupling{}.torsional_stiffness,
           py::arg("step") = std::map<std::string, double>{}, prose("Model.__init__"))
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
           py::arg("details") = false, prose("Model.follow"));
  RefusePickle(model,
               "a Model is not pickled: pickle its scene or bodies, and make it of them there");

  py::class_<Hand> proxy(module, "Proxy");
  proxy
      .def(py::init([](const Shared& shared, const py::object& pose) {
             return std::make_unique<Hand>(shared, ToCheckedPose(pose));
           }),
           py::arg("model"), py::arg("pose"), prose("Proxy.__init__"))
      .def_property_readonly("start_depth",
                             [](const Hand& hand) { return hand.proxy.start_depth(); })
      .def(
          "restart",
          [](Hand& hand, const py::object& pose) {
            const Pose X_WH = ToCheckedPose(pose);
            const Busy busy(hand);
            hand.Restart(X_WH);
          },
          py::arg("pose"), prose("Proxy.restart"))
      .def(
          "step",
          [](Hand& hand, const py::object& pose) {
            const Doubles row = ToPoses(pose, 1, "(3) or (7)");
            const Pose X_WH = ToPose(row.data(), row.size());
            const Busy busy(hand);
            const py::gil_scoped_release free;
            return Report{ToRecord(hand.Step(X_WH)), hand.shared.parameters};
          },
          py::arg("pose"), prose("Proxy.step"))
      .def("set_effect", &SetEffect, py::arg("effect"), py::kw_only(), py::arg("rate_hz") = 100.0,
           py::arg("max_force") = HeldWrench{}.max_force_N,
           py::arg("max_torque") = HeldWrench{}.max_torque_Nm, prose("Proxy.set_effect"))
      .def("steps", &StepAll, py::arg("poses"), py::kw_only(), py::arg("details") = false,
           prose("Proxy.steps"))
      .def("__repr__", [](const Hand& hand) { return Shown("Proxy", "of ", hand.shared.tool); });
  RefusePickle(
      proxy,
      "a Proxy cannot be pickled, because its state belongs to this process; pickle its poses");
}

}  // namespace palpate
