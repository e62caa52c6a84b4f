#pragma once

#include <span>

#include <Eigen/Core>

#include "common/math/pose.h"
#include "common/qp/nearest_point.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

class ContactRows;
class CutField;

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// Where a sub-step begins.
struct EnergyStart {
  Pose X_WT;                       ///< of the tool; its origin here is the reference point
  std::span<const CutField> cuts;  ///< what has been removed from each solid; empty: nothing cuts
  double reach;                    ///< how far ahead a bur finds material [m]
};

/// How the solver evaluates an energy.
struct Evaluation {
  const Kernels& kernels;
  double spring;  ///< stiffness of the spring for which a threshold stands, over k_t; 0: without
                  ///< thresholds
  bool with_hessian;
};

/// A convex energy of a step x = [v; rho phi], added to that of the coupling: something that pushes
/// the tool but does not block it.  Everything is divided by the coupling's stiffness k_t, so
/// forces are lengths.  A new one derives from this class and is entered in the constructor of
/// Energies (solve/energies.cpp); the solver knows no kind.
class Energy {
 public:
  virtual ~Energy() = default;

  /// Called where a sub-step begins.
  virtual void Begin(const EnergyStart&) noexcept {}
  /// Called before each solve.  Returns whether the energy acts.
  /// @param rows   of contacts
  /// @param rigid  rows that nothing may violate; an energy takes those out that yield to it
  virtual bool Collect(const ContactRows& rows, QpRows& rigid) noexcept {
    (void)rows, (void)rigid;
    return true;
  }

  /// Adds its value at x, its force and, if asked for, its Hessian.  Returns how many of its parts
  /// push: of something dense, one or none.
  virtual int Add(const Evaluation& by, const double* x, EnergyAt& at) const noexcept = 0;
  /// Rows of which each costs a threshold times what it lacks.  The solver may hold such a row at
  /// rest: then it evaluates the energy without thresholds and adds their forces to `push`.  Null:
  /// there are none.
  virtual const YieldingRows* thresholds() const noexcept { return nullptr; }

  // At the solver's result:
  int pushing = 0;            ///< number of parts that push
  Vec6 force = Vec6::Zero();  ///< the sum of their forces, on [v; rho phi] [m]
};

/// An energy of rows that yield one by one.
class YieldingEnergy : public Energy {
 public:
  int Add(const Evaluation& by, const double* x, EnergyAt& at) const noexcept override {
    YieldingRows rows = yielding;
    if (by.spring == 0.0) rows.threshold = nullptr;
    const auto add =
        by.with_hessian ? by.kernels.add_yielding_with_hessian : by.kernels.add_yielding;
    return add(rows, x, by.spring, at);
  }
  const YieldingRows* thresholds() const noexcept override {
    return yielding.threshold == nullptr ? nullptr : &yielding;
  }

  YieldingRows yielding{};
};

}  // namespace palpate
