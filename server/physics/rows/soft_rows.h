#pragma once

#include <memory>

#include "common/math/pose.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/tree/soft_leaves.h"

namespace palpate {

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
