#include <limits>

#include "common/math/rotation.h"
#include "server/physics/solve/stages.h"

namespace palpate {

void ReportContacts(StepContext& context) noexcept {
  const Advance& advance = context.advance;
  const ContactRows& rows = context.buffers().rows;
  const Optimum& optimum = advance.optimum;
  const SoftRows* soft = context.buffers().energies ? context.buffers().energies->soft() : nullptr;
  const SoftContacts yielding = soft != nullptr ? soft->Contacts() : SoftContacts{};
  const double k_t = context.model.parameters().stiffness;
  const Mat3 R_WG = context.tools.q_G.toRotationMatrix();
  StepReport& report = context.report();
  report.contacts = 0;
  const CutRows* bur = context.buffers().energies ? context.buffers().energies->bur() : nullptr;
  report.soft_contacts = yielding.count + (bur != nullptr ? 1 : 0);
  report.bur_force.setZero();
  if (bur != nullptr) {
    report.bur_force = k_t * bur->force.head<3>();
    report.bur_W = context.tools.p_G +
                   RotationExp(advance.phi) *
                       (R_WG * (context.model.cutting()->X_TB.p - context.model.reference()));
  }
  if (soft != nullptr) {
    report.soft_wrench = {k_t * soft->force.head<3>(),
                          k_t * context.model.rotation_length() * soft->force.tail<3>()};
  }
  const auto add = [&](int i, double offset, double force) {
    ActiveRow& row = report.active[static_cast<std::size_t>(report.contacts++)];
    row.id = rows.id(i);
    row.tool = rows.with_others() ? rows.other(i).tool : -1;
    row.normal = rows.normal(i);
    row.lever_cross_normal = rows.lever_cross_normal(i);
    row.offset = offset - row.normal.dot(advance.v) - row.lever_cross_normal.dot(advance.phi);
    row.force = force;
    row.friction.setZero();
    row.stiffness = std::numeric_limits<double>::infinity();
    const Vec3 lever = rows.LeverOf(i, context.model.tool().leaves, R_WG);
    row.contact_W =
        context.tools.p_G + (row.id.IsOfLeaves() ? lever : RotationExp(advance.phi) * lever);
    row.object_leaf = context.model.LeafOf(row.id, context.state().solids);
    row.material = &context.model.MaterialOf(row.id, context.state().solids);
    return &row;
  };
  for (int k = 0; k < optimum.qp.active; ++k) {
    const int i = optimum.qp.row[k];
    ActiveRow* row = add(i, context.sub_step.rigid.b[i], k_t * optimum.qp.multiplier[k]);
    if (optimum.has_friction) row->friction = k_t * optimum.friction[static_cast<std::size_t>(k)];
  }
  for (int k = 0; k < yielding.listed && report.contacts < kMaxActiveRows; ++k) {
    const int i = yielding.row[k];
    add(i, -rows.gap(i), k_t * yielding.push[k])->stiffness = k_t * soft->weight(i);
  }
}

void ReportTouches(Party tools) noexcept {
  for (std::size_t i = 0; i < tools.size() && tools.size() > 1; ++i) {
    const StepContext& owner = *tools[i];
    const Optimum& optimum = owner.advance.optimum;
    for (int k = 0; k < optimum.qp.active; ++k) {
      const ActiveRow& own = owner.report().active[static_cast<std::size_t>(k)];
      if (own.tool < 0) continue;
      StepContext& touched = *tools[static_cast<std::size_t>(own.tool)];
      StepReport& report = touched.report();
      if (report.contacts == kMaxActiveRows) continue;
      ActiveRow& row = report.active[static_cast<std::size_t>(report.contacts++)];
      const ContactRows::Other& other = owner.buffers().rows.other(optimum.qp.row[k]);
      row = own;
      row.tool = static_cast<std::int32_t>(i);
      row.normal = other.v;
      row.lever_cross_normal = other.phi;
      row.friction = -own.friction;
    }
  }
}

}  // namespace palpate
