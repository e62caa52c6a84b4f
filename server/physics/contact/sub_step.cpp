#include "server/physics/contact/sub_step.h"

#include <algorithm>

#include "server/physics/contact/certify.h"
#include "server/physics/contact/touch_rows.h"
#include "server/physics/limits.h"
#include "server/physics/surface/separating_plane.h"

namespace palpate {

using namespace limits::mesh;

void BeginSubStep(MeshContact& contact, const Kernels& kernels, SeparationFront& front,
                  const ToolPose& from, std::span<const ContactId> active, std::int64_t most_looks,
                  ContactRows& rows) noexcept {
  contact.looks = {.most = most_looks};
  contact.meshes.kernels = &kernels;
  contact.motion = Motion(from);
  contact.trial = 0;
  contact.touches.clear();
  contact.of_rows.touch.clear();
  contact.of_rows.regains = true;
  NearPairs& near = contact.near;
  near.Begin(contact.meshes, front, from);

  // Opens the front as far as it must be to know the pairs that touched last.
  near.Cover(contact.meshes.margins.touching, 0.0, contact.looks);
  Certify(contact, Vec3::Zero(), Vec3::Zero(), Until::kEnough);
  if (active.empty()) return;
  for (NearPairs::Index k = 0; k < near.size(); ++k) {
    const NearPairs::Pair& pair = near[k];
    if (pair.split || !pair.nodes.AreTriangles()) continue;
    const ContactId id = IdOf(contact, pair.nodes);
    const bool was =
        std::ranges::any_of(active, [&](const ContactId& row) { return row.IsBeside(id); });
    if (was && contact.touches.size() < contact.touches.capacity())
      AddRowsThatTouch(contact, k, rows);
  }
}

bool CheckTrial(MeshContact& contact, const Vec3& v, const Vec3& phi, ContactRows& rows) noexcept {
  const bool is_free = Certify(contact, v, phi, Until::kEnough) == 0;
  AddRowsOfOpen(contact, rows);
  return is_free;
}

bool IsFree(MeshContact& contact, const Vec3& v, const Vec3& phi) noexcept {
  return Certify(contact, v, phi, Until::kFirst) == 0;
}

void Stay(MeshContact& contact) noexcept {
  contact.motion = Motion(contact.motion.from);
}

void EndSubStep(MeshContact& contact) noexcept {
  contact.near.Accept(contact.motion, contact.trial, contact.looks);
}

bool IsFree(const ToolAndBodies& meshes, const ToolPose& at) {
  const HullTree& tools = meshes.tool.tree;
  std::vector<NodesOfPair> left;
  for (const ContactBody& body : meshes.bodies) {
    left.push_back({tools.root(), body.tree.root(), &body});
  }
  while (!left.empty()) {
    const NodesOfPair nodes = left.back();
    left.pop_back();
    const HullTree& objects = nodes.body->tree;
    SeparatingPlane plane;
    if (FindPlane({tools, nodes.tool, meshes.tool.radius, objects, nodes.object}, {at, at},
                  Vec3::UnitZ(), kRounding, *meshes.kernels, plane)) {
      continue;
    }
    if (nodes.AreTriangles()) {
      const NearestPoints nearest = meshes.NearestAt(nodes, at);
      if (!(nearest.Distance() > 0.0)) return false;
      if (!(meshes.Gap(nodes, nearest.Direction(), at) > kRounding)) return false;
    } else if (tools.IsLarger(nodes.tool, objects, nodes.object)) {
      for (HullTree::Node child : tools.inner(nodes.tool).child) {
        left.push_back({child, nodes.object, nodes.body});
      }
    } else {
      for (HullTree::Node child : objects.inner(nodes.object).child) {
        left.push_back({nodes.tool, child, nodes.body});
      }
    }
  }
  return true;
}

}  // namespace palpate
