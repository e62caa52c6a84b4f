#include "server/physics/solve/contact_wear.h"

namespace palpate {

void WearContacts(const HapticModel& model, const Pose& X_before, LeafWear& wear,
                  StepReport& report) noexcept {
  const bool friction = model.parameters().features.friction != FrictionModel::kOff;
  const Quat back = X_before.q * report.X_WG.q.conjugate();
  for (int i = 0; i < report.contacts; ++i) {
    const ActiveRow& row = report.active[static_cast<std::size_t>(i)];
    const int leaf = row.object_leaf;
    // Where the point of the tool that touches was before the step.
    const Vec3 before = X_before.p + back * (row.contact_W - report.X_WG.p);
    const Vec3 moved = row.contact_W - before;
    const Vec3 slip = moved - row.normal * row.normal.dot(moved);
    const double mu = friction ? row.material->dynamic_friction : 1.0;
    if (wear.Scrape(leaf, mu * row.force * slip.norm())) {
      report.removed[static_cast<std::size_t>(report.removals++)] = leaf;
    }
  }
}

}  // namespace palpate
