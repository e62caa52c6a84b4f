#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "server/physics/contact_rows.h"
#include "server/physics/haptic_step.h"

namespace palpate {

/// How far a soft leaf lets itself be entered, as a share of its radius: inside is a rigid core
/// with the same centre.  The force goes on without a jump where the core is met, only its slope
/// changes; the normal cannot flip, for no ball gets past the centre of another.
inline constexpr double kSoftShare = 0.5;

/// Depth of that core below the leaf's surface [m]; 0 where the material is rigid.
inline double CoreDepth(const Material& material, double leaf_radius) {
  return material.stiffness < std::numeric_limits<double>::infinity() ? kSoftShare * leaf_radius
                                                                      : 0.0;
}

/// What a leaf's finite stiffness means to the step.  Immutable.
class SoftLeaves {
 public:
  struct Leaf {
    double weight = 0.0;  ///< stiffness over that of the coupling: 1 / c; 0 where it is rigid
    double depth = 0.0;   ///< CoreDepth [m]
  };
  /// Null where no leaf is soft.  Throws Error where a stiffness is not positive.
  static std::unique_ptr<const SoftLeaves> Make(const ObjectForest& objects,
                                                double coupling_stiffness);
  /// What has a surface is rigid.
  Leaf of(const LeafPair& pair) const {
    return KindOf(pair) == RowKind::kLeaves ? leaves_[static_cast<std::size_t>(pair.object)]
                                            : Leaf{};
  }

 private:
  std::vector<Leaf> leaves_;
};

/// The soft rows that push at a step's optimum.
struct SoftContacts {
  int count = 0;               ///< all of them
  Vec3 force = Vec3::Zero();   ///< their sum on the tool, over the coupling's stiffness [m]
  Vec3 torque = Vec3::Zero();  ///< ... about the reference point [m^2]
  int listed = 0;  ///< those of the greatest force, greatest first, of equals the first row
  int row[kMaxActiveRows];
  double push[kMaxActiveRows];  ///< force over the coupling's stiffness [m]
};

/// The compliance of the rows of one sub-step, column by column beside ContactRows.
class SoftRows {
 public:
  /// @param rho  of ContactRows [m].
  SoftRows(int rows, double rho);

  /// Looks up the rows' leaves.  To be called after ContactRows::Finish.
  void Set(const SoftLeaves& leaves, const ContactRows& rows) noexcept;
  /// True where any of the rows is soft.
  bool any() const { return any_; }
  /// The rows as the solver wants them; `rows` as in Set.
  CompliantRows view(const ContactRows& rows);
  /// Those that push at the optimum which the solver found last.
  SoftContacts Contacts(const ContactRows& rows) const noexcept;
  /// Weight of a row, 0 where it is rigid.
  double weight(int row) const { return weight_[row]; }
  /// The rows that no step may violate: rigid ones, and the cores of soft ones.
  QpRows rigid(const ContactRows& rows) const;

 private:
  struct AlignedDelete {
    void operator()(double* p) const;
  };
  std::unique_ptr<double[], AlignedDelete> storage_;
  double* weight_;
  double* rigid_b_;
  double* transformed_[6];
  double* push_;
  double pull_[6];
  int pushing_ = 0;
  double rho_;
  bool any_ = false;
};

}  // namespace palpate
