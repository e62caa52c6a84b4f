#include "server/physics/contact/mesh_contact.h"

namespace palpate {
namespace {

limits::mesh::Margins MarginsOf(const ContactBody& tool, double separation) {
  limits::mesh::Margins margins{separation};
  // Half of delta is left for the error of a row.  A ball has one row for each pair, whose only
  // error along the pair's plane is rounding.  With a smaller h it would roll about the edge at
  // which a face ends, at delta, until it is h from a face that is flush with the first.
  if (tool.radius > 0.0) margins.free = separation - limits::mesh::kRounding;
  return margins;
}

}  // namespace

MeshContact::MeshContact(const ContactBody& tool, std::span<const ContactBody> bodies, int max_rows,
                         double separation, int most_looks)
    : meshes{.tool = tool, .bodies = bodies, .margins = MarginsOf(tool, separation)},
      motion({Vec3::Zero(), Quat::Identity()}),
      near(most_looks) {
  const auto rows = static_cast<std::size_t>(max_rows);
  touches.reserve(static_cast<std::size_t>(most_looks));
  of_rows.touch.reserve(rows);
  of_rows.regain.resize(rows);
  released.reserve(rows);
  doubts.reserve(static_cast<std::size_t>(near.room()));
  open.reserve(static_cast<std::size_t>(near.room()));
}

Touch& MeshContact::TouchOf(NearPairs::Index k) {
  NearPairs::Pair& pair = near[k];
  if (pair.touch < 0) {
    pair.touch = static_cast<std::int32_t>(touches.size());
    touches.push_back(TouchAt(meshes, pair.nodes, motion.from));
  }
  return touches[static_cast<std::size_t>(pair.touch)];
}

}  // namespace palpate
