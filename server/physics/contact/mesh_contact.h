#pragma once

#include <cstdint>
#include <vector>

#include "server/physics/contact/near_pairs.h"
#include "server/physics/contact/touch.h"

namespace palpate {

/// The rows of a ContactRows that belong to touches, and what they ask for.
struct TouchRows {
  std::vector<Touch*> touch;   ///< for each row its touch; null, or beyond the end,
                               ///< for rows of leaves
  std::vector<double> regain;  ///< for each row: separation asked for beyond what its pair has [m]
  bool regains = true;         ///< whether rows ask for more separation than their pairs have
};

/// A row that was taken out of its touch and can be put back.
struct ReleasedRow {
  Touch* touch;
  int slot;  ///< index into touch->row
  int row;
  double gap;  ///< gap of the row when it was taken out [m]
};

/// The data of one sub-step between a tool and bodies, which the functions of this folder
/// read and write (touch_rows.h, reconcile.h) in the order given in sub_step.h.  All memory
/// is allocated on construction.
struct MeshContact {
  /// @param max_rows    of the ContactRows that it will fill
  /// @param separation  to be kept between the meshes [m]
  /// @param most_looks  of a sub-step
  MeshContact(const ContactBody& tool, std::span<const ContactBody> bodies, int max_rows,
              double separation, int most_looks);

  ToolAndBodies meshes;
  Motion motion;           ///< the trial that was examined last
  std::int32_t trial = 0;  ///< its number within the sub-step
  NearPairs near;
  std::vector<Touch> touches;  ///< of those near pairs of triangles that were examined closely
  TouchRows of_rows;
  std::vector<ReleasedRow> released;  ///< by the last Release
  Looks looks;
  /// Scratch of Certify: near pairs whose planes do not hold, sorted by the gap that is left.
  std::vector<std::int64_t> doubts;
  /// Near pairs of triangles without a plane at the trial, in the order in which they were found.
  std::vector<NearPairs::Index> open;

  /// Returns the touch of a near pair of triangles, making it if needed.
  Touch& TouchOf(NearPairs::Index k);
  /// Returns whether a near pair has a touch, or there is room for one.
  bool HasRoomFor(const NearPairs::Pair& pair) const {
    return pair.touch >= 0 || touches.size() < touches.capacity();
  }
  /// Returns the touch that a row belongs to; null for a row of leaves.
  Touch* TouchOfRow(int row) const {
    const auto r = static_cast<std::size_t>(row);
    return r < of_rows.touch.size() ? of_rows.touch[r] : nullptr;
  }
};

}  // namespace palpate
