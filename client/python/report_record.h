#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "client/python/arrays.h"
#include "server/library/scenes.h"

namespace palpate {

/// A contact listed in a report, as a NumPy record; client/python/palpate/__init__.pyi describes
/// its columns.  Neither record has padding, so equal records have equal bytes.
struct RowRecord {
  std::int32_t body, tool_part, object_part, row;
  std::int64_t object_leaf;
  double point_m[3], normal[3], lever_cross_normal_m[3];
  double offset_m, force_N, friction_N[3];
  double stiffness_N_per_m, static_friction, dynamic_friction;
};

/// All fields of a StepReport and its StageTimes.
struct ReportRecord {
  double force_N[3], torque_Nm[3], tool[7];
  double soft_force_N[3], soft_torque_Nm[3], bur_force_N[3], bur_m[3];
  std::uint32_t faults;
  std::int32_t contacts, soft_contacts, listed, substeps, qp_iterations;
  std::int32_t friction_iterations, friction_yielded, friction_unsolved, friction_resets;
  std::int64_t predicted_pairs;
  double truncation_m;
  std::int64_t prediction_ns, rows_ns, solve_ns, response_ns;
  RowRecord rows[7];
};

/// Returns the number of contacts, listed or not.
inline int Contacts(const StepReport& report) {
  int rigid = 0;
  while (rigid < report.contacts && std::isinf(report.active[rigid].stiffness)) ++rigid;
  return rigid + report.soft_contacts;
}

inline RowRecord ToRecord(const ActiveRow& row) {
  RowRecord out{};
  out.body = row.id.body;
  out.tool_part = row.id.a;
  out.object_part = row.id.b;
  out.row = row.id.row;
  out.object_leaf = row.object_leaf;
  out.offset_m = row.offset;
  out.force_N = row.force;
  out.stiffness_N_per_m = row.stiffness;
  Vec3::Map(out.point_m) = row.contact_W;
  Vec3::Map(out.normal) = row.normal;
  Vec3::Map(out.lever_cross_normal_m) = row.lever_cross_normal;
  Vec3::Map(out.friction_N) = row.friction;
  if (row.material) {
    out.static_friction = row.material->static_friction;
    out.dynamic_friction = row.material->dynamic_friction;
  }
  return out;
}

inline void ToRecord(const StepReport& report, const StageTimes& times, ReportRecord& out) {
  out.faults = report.faults;
  out.contacts = Contacts(report);
  out.soft_contacts = report.soft_contacts;
  out.listed = report.contacts;
  out.substeps = report.diagnostics.substeps;
  out.predicted_pairs = report.diagnostics.predicted_pairs;
  out.qp_iterations = report.diagnostics.qp_iterations;
  out.friction_iterations = report.diagnostics.friction_iterations;
  out.friction_yielded = report.diagnostics.friction_yielded;
  out.friction_unsolved = report.diagnostics.friction_unsolved;
  out.friction_resets = report.diagnostics.friction_resets;
  out.truncation_m = report.diagnostics.truncation;
  out.prediction_ns = times.prediction;
  out.rows_ns = times.rows;
  out.solve_ns = times.solve;
  out.response_ns = times.response;
  Vec3::Map(out.force_N) = report.wrench.force;
  Vec3::Map(out.torque_Nm) = report.wrench.torque;
  FromPose(report.X_WG, out.tool);
  Vec3::Map(out.soft_force_N) = report.soft_wrench.force;
  Vec3::Map(out.soft_torque_Nm) = report.soft_wrench.torque;
  Vec3::Map(out.bur_force_N) = report.bur_force;
  Vec3::Map(out.bur_m) = report.bur_W;
  for (int i = 0; i < report.contacts; ++i) out.rows[i] = ToRecord(report.active[i]);
  std::fill(std::begin(out.rows) + report.contacts, std::end(out.rows), RowRecord{});
}

}  // namespace palpate
