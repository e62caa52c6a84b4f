#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "client/python/arrays.h"
#include "client/python/hand.h"
#include "client/python/model.h"
#include "client/python/prose.h"
#include "client/python/report_record.h"

namespace palpate {

/// The result of one step, with the same names as those of many.
struct Report {
  ReportRecord record;  // not initialised
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
  /// Returns the part that an index, a slice or a mask of paths and steps chooses.
  Steps At(const py::object& at) const;
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
  /// Writes the first step.
  void Put(const StepReport& report, const StageTimes& times) const {
    Vec3::Map(wrench) = report.wrench.force;
    Vec3::Map(wrench + 3) = report.wrench.torque;
    FromPose(report.X_WG, pose);
    *contacts = Contacts(report);
    *faults = report.faults;
    if (details) ToRecord(report, times, *details);
  }
  /// Marks steps that were not taken.
  void Blank(py::ssize_t count) const {
    std::fill_n(wrench, 6 * count, std::numeric_limits<double>::quiet_NaN());
    std::fill_n(pose, 7 * count, std::numeric_limits<double>::quiet_NaN());
    std::fill_n(contacts, count, 0);
    std::fill_n(faults, count, kFaultNotStarted);
    if (details) std::fill_n(details, count, ReportRecord{});
  }
  double *wrench, *pose;
  std::int32_t* contacts;
  std::uint32_t* faults;
  ReportRecord* details;  // may be null
};

/// Converts an array to poses.  A row that is not finite becomes a fault of its step; a quaternion
/// of another length is an error.
/// @param shape   in words
/// @param on_bad  "fault", or "raise": a row that is not finite is an error, too
Doubles ToPoses(const py::object& given, py::ssize_t dimensions, const char* shape,
                const std::string& on_bad = "fault");

void DefineReports(py::module_& module);
void DefineModels(py::module_& module, const Prose& prose);

}  // namespace palpate
