#pragma once

#include "common/math/pose.h"
#include "server/physics/energy/energy.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/aligned_columns.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// The soft rows that push at a step's optimum.
struct SoftContacts {
  int count = 0;   ///< all of them
  int listed = 0;  ///< those of the greatest force, greatest first, of equals the first row
  int row[kMaxActiveRows];
  double push[kMaxActiveRows];  ///< force over the coupling's stiffness [m]
};

/// The compliance of the rows of one sub-step, column by column beside ContactRows: leaf springs in
/// series with the coupling, a diagonal in the QP's dual.  Any number may yield at once, so they
/// are not taken up one by one: they are an energy.
class SoftRows : public Energy {
 public:
  /// @param rows  at most.  Set-up.
  explicit SoftRows(int rows) : columns_(3, static_cast<std::size_t>(rows) + 16) {}

  /// Looks up the rows' leaves.  A row that is not between leaves is rigid.  To be called after
  /// ContactRows::Finish.
  void Set(const ObjectForest& objects, double coupling_stiffness,
           const ContactRows& rows) noexcept;
  /// True where any of the rows is soft.
  bool any() const { return any_; }
  /// Those that push at the optimum which the solver found last.
  SoftContacts Contacts() const noexcept;
  bool pushes() const { return pushing_ > 0; }
  /// Their sum there, of [v; rho phi], over the coupling's stiffness [m].
  const double* force() const { return force_; }
  /// Weight of a row, 0 where it is rigid.
  double weight(int row) const { return columns_[kWeight][row]; }
  /// The rows that no step may violate: rigid ones, and the cores of soft ones.
  QpRows rigid() const;

  void Add(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
           EnergyAt& at) noexcept override;
  void AddHessian(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
                  EnergyAt& at) const noexcept override;

 private:
  enum : std::size_t { kWeight, kRigidB, kPush };
  YieldingRows Yielding() const { return {rows_, columns_[kWeight], nullptr, columns_[kPush]}; }

  AlignedColumns columns_;
  QpRows rows_{};  ///< those of the sub-step
  double force_[6] = {};
  int pushing_ = 0;
  bool any_ = false;
};

}  // namespace palpate
