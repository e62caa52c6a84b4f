#pragma once

#include "common/math/pose.h"
#include "server/physics/energy/energy.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/aligned_columns.h"

namespace palpate {

/// The soft rows that push at a step's optimum.
struct SoftContacts {
  int count = 0;   ///< number of all of them
  int listed = 0;  ///< number of those listed: the greatest forces, in falling order; of equal
                   ///< ones, the first row
  int row[kMaxActiveRows];
  double push[kMaxActiveRows];  ///< force over the coupling's stiffness [m]
};

/// The compliance of the rows of one sub-step, column by column beside ContactRows: springs of the
/// leaves in series with the coupling, a diagonal in the QP's dual.  Since any number of rows may
/// yield at once, they are treated as an energy, not as single constraints.
class SoftRows : public YieldingEnergy {
 public:
  /// @param model  must outlive this.  Set-up.
  explicit SoftRows(const HapticModel& model)
      : model_(model), columns_(3, static_cast<std::size_t>(model.parameters().max_rows) + 16) {}

  /// Queries up the rows' leaves.  A row that is not between leaves is rigid.  If any row is soft,
  /// `rigid` become the rows that no step may violate: rigid ones, and the cores of soft ones.
  bool Collect(const ContactRows& rows, QpRows& rigid) noexcept override;
  /// Returns whether any row is soft.
  bool any() const { return any_; }
  /// Returns the rows that push at the optimum that the solver found last.
  SoftContacts Contacts() const noexcept;
  /// The weight of a row; 0 if it is rigid.
  double weight(int row) const { return columns_[kWeight][row]; }

 private:
  enum : std::size_t { kWeight, kRigidB, kPush };

  const HapticModel& model_;
  AlignedColumns columns_;
  bool any_ = false;
};

}  // namespace palpate
