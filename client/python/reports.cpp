#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "client/python/steps.h"

// Report and Steps.

namespace palpate {
namespace {

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

/// Returns three columns of wrenches, as a view.
py::object AxesOf(const py::array_t<double>& wrench, int first) {
  return wrench[py::make_tuple(py::ellipsis(), py::slice(first, first + 3, 1))];
}

py::ssize_t BadPoses(const Steps& steps) {
  const auto faults = py::array_t<std::uint32_t, py::array::c_style>(steps.faults);
  return std::count_if(faults.data(), faults.data() + faults.size(),
                       [](std::uint32_t fault) { return (fault & kFaultBadPose) != 0; });
}

}  // namespace

Steps Steps::At(const py::object& at) const {
  const auto taken = [&at](const py::object& array) -> py::object {
    return array.attr("__getitem__")(at);
  };
  Steps part;
  part.contacts = taken(contacts);
  part.faults = taken(faults);
  part.wrench = taken(wrench);
  part.pose = taken(pose);
  part.details = details.is_none() ? details : taken(details);
  part.parameters = parameters;
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
}

namespace {

void DefineReport(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(RowRecord, body, tool_part, object_part, row, object_leaf, point_m, normal,
                       lever_cross_normal_m, offset_m, force_N, friction_N, stiffness_N_per_m,
                       static_friction, dynamic_friction);
  PYBIND11_NUMPY_DTYPE(ReportRecord, force_N, torque_Nm, tool, soft_force_N, soft_torque_Nm,
                       bur_force_N, bur_m, faults, contacts, soft_contacts, listed, substeps,
                       predicted_pairs, qp_iterations, friction_iterations, friction_yielded,
                       friction_unsolved, friction_resets, truncation_m, prediction_ns, rows_ns,
                       solve_ns, response_ns, rows);
  module.attr("report_dtype") = py::dtype::of<ReportRecord>();
  py::class_<Report>(module, "Report")
      .def_property_readonly("force",
                             [](const Report& r) { return FromNumbers(r.record.force_N, 3); })
      .def_property_readonly("torque",
                             [](const Report& r) { return FromNumbers(r.record.torque_Nm, 3); })
      .def_property_readonly("wrench",
                             [](const Report& r) {
                               std::array<double, 6> wrench;
                               std::copy_n(r.record.torque_Nm, 3,
                                           std::copy_n(r.record.force_N, 3, wrench.begin()));
                               return FromNumbers(wrench.data(), 6);
                             })
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
}

void DefineSteps(py::module_& module) {
  py::class_<Steps>(module, "Steps")
      .def_readonly("wrench", &Steps::wrench)
      .def_property_readonly("force", [](const Steps& s) { return AxesOf(s.wrench, 0); })
      .def_property_readonly("torque", [](const Steps& s) { return AxesOf(s.wrench, 3); })
      .def_property_readonly("bad_poses", &BadPoses)
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
      .def("__getitem__", &Steps::At)
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
             const py::ssize_t bad = BadPoses(steps);
             return Shown("Steps", "of shape ", shape, ": ", touch, " in contact, faults ",
                          FaultWords(faults),
                          bad > 0 ? " (" + std::to_string(bad) + " bad poses)" : "");
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

void DefineReports(py::module_& module) {
  DefineReport(module);
  DefineSteps(module);
}

}  // namespace palpate
