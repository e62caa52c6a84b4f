#include "server/physics/contact/sub_step.h"

#include <algorithm>

#include "server/physics/limits.h"
#include "server/physics/surface/separating_plane.h"

namespace palpate {

using namespace limits::mesh;

namespace {

limits::mesh::Margins MarginsOf(const MovingBody& a, double separation) {
  limits::mesh::Margins margins{separation};
  // Half of delta is left for the error of a row.  A ball has one row for each pair, whose only
  // error along the pair's plane is rounding.  With a smaller h it would roll about the edge at
  // which a face ends, at delta, until it is h from a face that is flush with the first.
  if (a.radius > 0.0) margins.free = separation - limits::mesh::kRounding;
  return margins;
}

}  // namespace

MeshContact::MeshContact(const MovingBody& a, std::span<const ContactBody> b, std::int32_t frame,
                         int max_rows, double separation, Queries& shared, int most_queries)
    : meshes{.a = a, .b = b, .frame = frame, .margins = MarginsOf(a, separation)},
      motion({Vec3::Zero(), Quat::Identity()}),
      near(most_queries),
      queries(shared) {
  const auto rows = static_cast<std::size_t>(max_rows);
  corners.seen.resize(a.mesh.vertices().size());
  corners.met.reserve(corners.seen.size());
  scratch.in_body.resize(b.size());
  touches.reserve(static_cast<std::size_t>(most_queries));
  of_rows.touch.reserve(rows);
  of_rows.asked.resize(rows);
  ReserveEach(static_cast<std::size_t>(near.room()), scratch.doubts, open);
}

BodyContact::BodyContact(const MovingBody& a, std::span<const ContactBody> bodies, int max_rows,
                         double separation, int most_queries) {
  const std::size_t frames = CountFrames(bodies);
  of.reserve(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    of.emplace_back(a, bodies, static_cast<std::int32_t>(i), max_rows, separation, queries,
                    most_queries);
  }
}

Touch& MeshContact::TouchOf(NearPairs::Index k) {
  NearPairs::Pair& pair = near[k];
  if (pair.touch < 0) {
    pair.touch = static_cast<std::int32_t>(touches.size());
    touches.push_back(TouchAt(meshes, near.Nodes(k), motion.from));
  }
  return touches[static_cast<std::size_t>(pair.touch)];
}

void BeginSubStep(MeshContact& contact, const Kernels& kernels, SeparationFront& front,
                  const RelativePose& from, std::span<const ContactId> active, First first,
                  FrameRows& rows) noexcept {
  contact.meshes.kernels = &kernels;
  contact.motion = Motion(from);
  contact.candidate = 0;
  contact.touches.clear();
  contact.of_rows.touch.clear();
  contact.of_rows.regains = true;
  contact.of_rows.least = contact.meshes.margins.separation;
  NearPairs& near = contact.near;
  near.Begin(contact.meshes, front, from);

  // Splits the front as far as needed to find the pairs that touched last.
  near.Cover(contact.meshes.margins.touching, 0.0, contact.queries);
  Certify(contact, Vec3::Zero(), Vec3::Zero(), Until::kEnough);
  if (active.empty() && first == First::kActive) return;
  const auto was_active = [&](const NodesOfPair& nodes) {
    const ContactId id = IdOf(nodes);
    return std::ranges::any_of(active, [&](const ContactId& row) { return row.IsBeside(id); });
  };
  const bool all_corners = first == First::kAllCorners;
  const auto touches = [&](NearPairs::Index k) {
    if (first == First::kActive) return false;
    const Touch& touch = contact.TouchOf(k);
    return touch.distance <= contact.meshes.margins.touching &&
           (first == First::kTouching || touch.in_cone);
  };
  for (NearPairs::Index k = 0; k < near.size() && contact.HasRoomForTouch(); ++k) {
    if (near[k].split) continue;
    const NodesOfPair nodes = near.Nodes(k);
    if (!nodes.AreTriangles() || (!was_active(nodes) && !touches(k))) continue;
    if (all_corners) {
      AddRowsOnFace(contact, contact.TouchOf(k), rows);
    } else {
      AddRowsThatTouch(contact, k, rows);
    }
  }
  if (!all_corners || contact.meshes.IsBall()) return;
  AddRowsOfHidden(contact, active, contact.meshes.margins.touching, rows);
  AddRowsOfCorners(contact, rows);
}

bool CheckCandidate(MeshContact& contact, const Vec3& v, const Vec3& phi,
                    FrameRows& rows) noexcept {
  const bool is_free = Certify(contact, v, phi, Until::kEnough) == 0;
  AddRowsOfOpen(contact, rows);
  return is_free;
}

bool CheckRest(MeshContact& contact, const Vec3& v, const Vec3& phi, FrameRows& rows) noexcept {
  Margins& margins = contact.meshes.margins;
  const Margins moving = margins;
  margins.rest = std::min(margins.separation, contact.of_rows.least) - kRounding;
  margins.free = margins.rest = std::max(margins.free, margins.rest);
  const bool may_rest =
      Certify(contact, v, phi, Until::kEnough) == 0 || !AddRowsOfOpen(contact, rows);
  margins = moving;
  return may_rest;
}

bool IsFree(MeshContact& contact, const Vec3& v, const Vec3& phi) noexcept {
  return Certify(contact, v, phi, Until::kFirst) == 0;
}

void EndSubStep(MeshContact& contact, bool merges) noexcept {
  contact.near.Accept(contact.motion, contact.candidate);
  if (merges) contact.near.Merge(contact.motion.to, contact.queries);
}

namespace {

/// Returns whether two nodes are apart.  A block whose body cannot be made counts as not apart.
bool AreApart(const MeshPair& meshes, const NodesOfPair& nodes, const RelativePose& at) {
  const HullTree &tree_a = meshes.a.tree, &tree_b = nodes.shape->tree;
  SeparatingPlane plane;
  const Placement X_SA = meshes.FrameOf(nodes).Inverse() * at;
  if (FindPlane(meshes.PatchesOf(nodes), {X_SA, X_SA}, Vec3::UnitZ(), kRounding, *meshes.kernels,
                plane)) {
    return true;
  }
  if (nodes.AreTriangles()) {
    const NearestPoints nearest = meshes.NearestAt(nodes, at);
    return nearest.Distance() > 0.0 && meshes.Gap(nodes, nearest.Direction(), at) > kRounding;
  }
  const auto are_apart = [&](HullTree::Node a, HullTree::Node b) {
    return AreApart(meshes, {a, b, nodes.shape, nodes.number, nodes.placed}, at);
  };
  if (tree_a.IsLarger(nodes.a, tree_b, nodes.b)) {
    const auto& child = tree_a.inner(nodes.a).child;
    return are_apart(child[0], nodes.b) && are_apart(child[1], nodes.b);
  }
  if (const std::int32_t block = tree_b.BlockOf(nodes.b); block >= 0) {
    const auto taken = meshes.solids->Take({nodes.number, nodes.b, block}, SeparationFront());
    if (taken.body < 0 || meshes.solids->IsNothing(taken.body)) return taken.body >= 0;
    const HullTree::Node root = meshes.solids->Body(taken.body).shape.tree.root();
    return AreApart(meshes, meshes.NodesOf(nodes.a, root, taken.body), at);
  }
  const auto& child = tree_b.inner(nodes.b).child;
  return are_apart(nodes.a, child[0]) && are_apart(nodes.a, child[1]);
}

}  // namespace

bool IsFree(const MeshPair& meshes, const RelativePose& at) {
  for (std::size_t number = 0; number < meshes.b.size(); ++number) {
    if (meshes.b[number].frame != meshes.frame) continue;
    const HullTree& tree = meshes.b[number].shape->tree;
    const auto of_a = tree.IsOfBlocks() ? meshes.ForSolids() : std::optional(meshes.a.tree.root());
    if (!of_a) continue;
    const auto body = static_cast<std::int32_t>(number);
    if (!AreApart(meshes, meshes.NodesOf(*of_a, tree.root(), body), at)) return false;
  }
  return true;
}

}  // namespace palpate
