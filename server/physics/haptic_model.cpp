#include "server/physics/haptic_model.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/coupling_fault.h"
#include "common/error.h"
#include "server/physics/limits.h"

namespace palpate {

namespace {

bool IsUncut(const PlacedTree& object) {
  return !object.is_cut;
}

bool TouchesByLeaves(const PlacedTree& object) {
  return !object.is_cut && !TouchesByMesh(object);
}

bool IsRigidObject(const PlacedTree& object) {
  return object.tool < 0 && TouchesByMesh(object);
}

}  // namespace

SceneObjects::SceneObjects(std::span<const PlacedTree> objects, ContactModel contact_model,
                           std::vector<CutSolid> cut_solids, std::vector<MovedGroup> moved_groups)
    : contact(contact_model),
      forest(objects, contact == ContactModel::kSurface ? &TouchesByLeaves : &IsUncut),
      solids(std::move(cut_solids)),
      moved(std::move(moved_groups)) {
  for (const PlacedTree& object : objects) {
    if (object.frame == 0 || (contact == ContactModel::kSurface && TouchesByMesh(object))) continue;
    throw Error(
        "an object moves that is touched by its leaves, or cut: only rigid meshes can move; use "
        "\"contact\": \"surface\", and a material without stiffness");
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (const std::string fault = MotionFault(moved[i]); !fault.empty()) {
      throw Error(moved[i].name + ": " + fault);
    }
    const auto number = static_cast<std::int32_t>(i + 1);
    if (std::ranges::count(objects, number, &PlacedTree::frame) == 0) {
      throw Error(moved[i].name + ": moves no object; name it in one as \"moved\"");
    }
  }
  if (contact != ContactModel::kSurface) return;
  bodies = MakeBodies(objects);
  if (!bodies.empty()) insides.emplace(objects, &IsRigidObject);
  for (const CutSolid& solid : solids) bodies.push_back(BlocksOf(solid));
  box_count = solids.size();
  uncut = UncutBodies(solids, boxes(), bodies.size() - box_count);
}

HapticModel::HapticModel(const SphereTree& tool, std::shared_ptr<const SceneObjects> objects,
                         const StepParameters& parameters, const TriangleMesh* tool_mesh,
                         std::optional<Cutting> cutting, Effects effects,
                         std::optional<Inertia> inertia)
    : parameters_(parameters),
      objects_(std::move(objects)),
      cutting_(std::move(cutting)),
      effects_(std::move(effects)),
      inertia_(std::move(inertia)) {
  if (const std::string fault = TuningFault(parameters_); !fault.empty()) {
    throw Error("step: " + fault);
  }
  const auto positive = [](double value, const char* name) {
    if (value > 0.0 && std::isfinite(value)) return;
    throw Error(std::string("step parameters: ") + name + " is " + std::to_string(value) +
                "; give a positive number");
  };
  positive(parameters_.stiffness, "stiffness");
  positive(parameters_.torsional_stiffness, "torsional_stiffness");
  positive(parameters_.max_rows, "max_rows");
  rotation_length_ = std::sqrt(parameters_.torsional_stiffness / parameters_.stiffness);
  if (parameters_.features.contact != objects_->contact) {
    throw Error("step parameters: contact differs from the objects'; give MakeObjects the same");
  }
  const double extent = this->objects().center.norm() + this->objects().radius;
  tool_ = std::make_unique<const ToolTree>(tool, extent);
  if (!bodies().empty())
    tool_body_ = MakeMovingBody(tool_mesh, tool, tool_->reference, cutting_ ? &*cutting_ : nullptr);
  const double reach = tool_body_ != nullptr ? tool_body_->mesh.reach() : 0.0;
  const double lever = std::max(tool_->max_lever, reach);
  const std::string fault =
      CouplingFault(parameters_.stiffness, parameters_.torsional_stiffness, lever);
  if (!is_ball() && !fault.empty()) {
    throw Error("step parameters: torsional_stiffness: " + fault);
  }
  parameters_.max_truncation = tool_body_ != nullptr
                                   ? limits::mesh::Margins{parameters_.separation}.truncation
                                   : limits::kMaxTruncation;
  parameters_.max_rotation = std::min(
      std::sqrt(2.0 * parameters_.max_truncation / std::max(lever, limits::kShortestLever)),
      limits::kMostRotation);
  if (cutting_) SetCutting();
  if (!cutting_ && !solids().empty() && boxes().empty()) {
    throw Error(
        "with sphere contact, a tool without a bur would pass through an object that burs cut; "
        "give it a bur, or use \"contact\": \"surface\"");
  }
}

void HapticModel::SetCutting() {
  bur_samples_ = cutting_->bur.Samples(cutting_->samples);
  const double tip = cutting_->bur.low();
  const double top = cutting_->cutting > 0.0 ? tip + cutting_->cutting : 1e300;
  for (BurSample& sample : bur_samples_) {
    const double z = sample.point.z();
    sample.cuts = z >= tip + cutting_->dead_tip && z <= top;
    if (cutting_->sense) {
      const double lean = (cutting_->X_TB.q * sample.normal).dot(*cutting_->sense);
      sample.cuts = sample.cuts && lean > -limits::cutting::kRelief;
    }
    // Clockwise, seen along the axis from the shank to the tip.
    const Vec3 slide(sample.point.y(), -sample.point.x(), 0.0);
    if (cutting_->spin.speed > 0.0 && slide.squaredNorm() > 0.0) {
      sample.slide = cutting_->X_TB.q * slide.normalized();
    }
    sample.point = cutting_->X_TB * sample.point - reference();
    sample.normal = cutting_->X_TB.q * sample.normal;
  }
}

std::int32_t HapticModel::LeafOf(const ContactId& id, const SolidBodies& blocks) const {
  if (id.IsOfLeaves()) return id.b;
  const auto body = static_cast<std::size_t>(id.body);
  if (body < bodies().size()) {
    const ContactBody& of = bodies()[body];
    return of.first_leaf + of.shape->leaf[static_cast<std::size_t>(id.b)];
  }
  return objects().first_leaf[solids()[blocks.SolidOf(id.body)].object];
}

const Material& HapticModel::MaterialOf(const ContactId& id, const SolidBodies& blocks) const {
  const bool of_solid = !id.IsOfLeaves() && id.body >= static_cast<std::int32_t>(bodies().size());
  if (!of_solid) return objects().MaterialOf(LeafOf(id, blocks));
  return solids()[blocks.SolidOf(id.body)].materials[blocks.MaterialOf(id.body, id.b)];
}

}  // namespace palpate
