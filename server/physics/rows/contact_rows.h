#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "common/qp/nearest_point.h"
#include "server/physics/simd/aligned_columns.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// The linearised non-penetration constraints of one sub-step (chapter 2.10-2.17), in distance
/// form: gap g = |c_T - c_O| - (r_T + r_O), n = (c_T - c_O) / |c_T - c_O|, and the row
///   [n; (l x n) / rho] . x >= -g   for   x = [v; rho phi],
/// with l the leaf's lever arm about the reference point.  rho = sqrt(k_r / k_t) makes the
/// objective |x - x_h|^2.  For translation the half-space lies inside the true free space; a
/// rotation adds at most 1/2 |phi|^2 |l| of penetration.
class ContactRows {
 public:
  /// Allocates storage for max_rows rows.
  /// @param turns  false for a ball, which no row turns
  /// @param with_others  whether rows may name a second body whose motion is unknown, too
  ContactRows(int max_rows, double rho, bool turns = true, bool with_others = false);

  /// What the motion [v; phi] of another tool adds to a row: v . x_v + phi . x_phi.
  struct Other {
    int tool = -1;  ///< its number; negative: the row names no other tool
    Vec3 v, phi;    ///< [1], [m]
  };

  void Clear() noexcept { count_ = 0; }
  /// Adds the rows of leaf pairs; if they do not all fit, adds none and returns false.
  [[nodiscard]] bool Add(const Kernels& kernels, const LeafSphere* tool, const LeafSphere* object,
                         const Mat3& R_WG, const Vec3& p_W, const NodePair* pairs,
                         int count) noexcept;
  /// Adds one row, for which there must be room.
  /// @param lever  of the contact point [m], in W
  void AddRow(const Vec3& normal, const Vec3& lever, double gap, const ContactId& id) noexcept;
  /// Changes a row, except its id.
  /// @param by_rotation  rate of the gap as phi grows [m]: lever x normal, or another vector if the
  ///                    normal turns, too
  void SetRow(int row, const Vec3& normal, const Vec3& lever, const Vec3& by_rotation,
              double gap) noexcept;
  void SetGap(int row, double gap) noexcept { columns_.b[row] = -gap; }
  /// Call after AddRow or SetRow; only if rows may name other tools.
  void SetOther(int row, const Other& other) noexcept { others_[Index(row)] = other; }
  bool with_others() const { return !others_.empty(); }
  const Other& other(int row) const { return others_[Index(row)]; }
  /// Makes a row hold for every step.
  void Loosen(int row) noexcept { columns_.b[row] = kLoose; }
  bool IsLoose(int row) const { return columns_.b[row] == kLoose; }
  /// Makes every row allow the zero step.
  void AdmitZero() noexcept {
    for (int i = 0; i < count_; ++i) columns_.b[i] = std::min(columns_.b[i], 0.0);
  }
  /// Pads to a multiple of 16 with rows that always hold.  Call after the last Add.
  void Finish() noexcept;

  int count() const { return count_; }
  int max_rows() const { return max_rows_; }
  QpRows view() const;
  const ContactId& id(int row) const { return columns_.id[row]; }
  /// Gap of a row [m].
  double gap(int row) const { return -columns_.b[row]; }
  /// Returns what a row has to spare after a step [m].
  double Left(int row, const Vec3& v, const Vec3& phi) const {
    return gap(row) + normal(row).dot(v) + lever_cross_normal(row).dot(phi);
  }
  Vec3 normal(int row) const {
    return {columns_.a[0][row], columns_.a[1][row], columns_.a[2][row]};
  }
  /// l x n [m].
  Vec3 lever_cross_normal(int row) const;
  /// Returns how far the row's direction in configuration space, [n; l x n / rho], is from another
  /// one with these parts [rad, if small].
  double AngleTo(int row, const Vec3& n, const Vec3& by_rotation) const;
  /// The same of the part that the other tool moves, by the first tool's rho.
  double AngleTo(int row, const Other& other) const;
  /// Lever arm of the contact point [m], in W; valid for rows from AddRow.
  Vec3 lever(int row) const {
    return {columns_.lever[0][row], columns_.lever[1][row], columns_.lever[2][row]};
  }
  /// Returns the vector from the tool's reference point to the point where a row touches, in W [m].
  /// @param tool  its leaves.   @param R_WG  its orientation.
  Vec3 LeverOf(int row, std::span<const LeafSphere> tool, const Mat3& R_WG) const;
  /// Writes the index of each id's row, skipping ids without one; returns how many were found, in
  /// the order of the ids.
  int Find(std::span<const ContactId> ids, int* row) const noexcept;

 private:
  static std::size_t Index(int row) { return static_cast<std::size_t>(row); }

  static constexpr double kLoose = -1e300;
  int max_rows_;
  bool turns_;
  double rho_;
  AlignedColumns storage_;
  std::vector<ContactId> ids_;
  std::vector<Other> others_;
  RowColumns columns_{};
  int count_ = 0;
};

}  // namespace palpate
