#pragma once

#include <cstdint>
#include <vector>

#include "server/physics/contact/near_pairs.h"
#include "server/physics/contact/touch.h"

namespace palpate {

/// Which rows of a ContactRows belong to touches, and what they ask for.
struct TouchRows {
  std::vector<Touch*> touch;   ///< of each row: its touch; null or beyond the end: of leaves
  std::vector<double> regain;  ///< of each row: asked for beyond what its pair has [m]
  bool regains = true;         ///< whether rows ask for more than their pairs have
};

/// A row that was taken out of its touch, and can be put back.
struct ReleasedRow {
  Touch* touch;
  int slot;  ///< in touch->row
  int row;
  double gap;  ///< that it had [m]
};

/// What one sub-step between a tool and bodies knows: data, which the functions of this folder read
/// and write (touch_rows.h, reconcile.h), in the order that sub_step.h gives them.  All
/// its memory is allocated when it is made.
struct MeshContact {
  /// @param max_rows    of the ContactRows that it is going to fill.
  /// @param separation  that it keeps [m].   @param most_looks  of a sub-step.
  MeshContact(const ContactBody& tool, std::span<const ContactBody> bodies, int max_rows,
              double separation, int most_looks);

  ToolAndBodies meshes;
  Motion motion;           ///< the trial that was looked at last
  std::int32_t trial = 0;  ///< its number in the sub-step
  NearPairs near;
  std::vector<Touch> touches;  ///< of those near pairs of triangles that a closer look was taken at
  TouchRows of_rows;
  std::vector<ReleasedRow> released;  ///< by the last Release
  Looks looks;
  /// Scratch of Certify: near pairs whose planes do not hold, by the gap that is left.
  std::vector<std::int64_t> doubts;
  /// Near pairs of triangles that have no plane at the trial, in the order in which they were
  /// found.
  std::vector<NearPairs::Index> open;

  /// The touch of a near pair of triangles, made where it has none.
  Touch& TouchOf(NearPairs::Index k);
  /// Whether a near pair may have a touch: there is room, or it has one.
  bool HasRoomFor(const NearPairs::Pair& pair) const {
    return pair.touch >= 0 || touches.size() < touches.capacity();
  }
  /// The touch whose row this is; null of leaves.
  Touch* TouchOfRow(int row) const {
    const auto r = static_cast<std::size_t>(row);
    return r < of_rows.touch.size() ? of_rows.touch[r] : nullptr;
  }
};

}  // namespace palpate
