#pragma once

#include "common/math/pose.h"
#include "scenes/free_body.h"
#include "server/physics/energy/energy.h"

namespace palpate {

/// What moves a free body: a hand's place is taken by its inertia (free_bodies.md).
struct Inertia {
  FreeBody body;
  Vec3 gravity = Vec3::Zero();  ///< [m/s^2]
};

/// What a free body remembers from step to step.
struct BodyState {
  Vec3 v = Vec3::Zero();         ///< of its centre, in W [m/s]
  Vec3 momentum = Vec3::Zero();  ///< angular, in W, about its centre or its ball joint [N m s]
  double joint = 0.0;  ///< hinge, slider: where it is, and its rate: [rad] or [m], and / s
  double rate = 0.0;
  int still = 0;  ///< steps in which it has hardly moved
  bool sleeps = false;
};

/// A body's energy in a step x = [v; rho phi] of its centre of mass, over k = m / h^2, as half of a
/// squared distance: x = B y + c, with y of as many unknowns as the joint leaves free (others have
/// zero columns), and y = A (x - c).
struct BodyMetric {
  Mat6 B, A;
  Vec6 c;  ///< leads the body back to its joint, which it leaves by the second order of a step
  // A joint's limits: rows limit[i] . x >= bound[i].
  int limits = 0;
  Vec6 limit[2];
  double bound[2];
};

/// The length rho that turns a body's rotations into lengths: of the same energy on average.
double RotationLengthOf(const FreeBody& body);

/// Returns where a body would be after a step of h [s] that nothing hinders: implicit Euler, with
/// its angular momentum kept, and its joint's springs and damping at the end.
/// Poses X are relative to where the body was placed.  Real-time, as the next ones.
Pose FreeMotion(const Inertia& inertia, const Pose& X, const BodyState& state, double h) noexcept;

/// Returns the metric of a step from X, with rho as of RotationLengthOf.
BodyMetric MetricAt(const Inertia& inertia, const Pose& X, const BodyState& state, double h,
                    double rho) noexcept;

/// Sets a body's velocities after it has moved in h from one pose to another.
void TakeVelocity(const Inertia& inertia, const Pose& from, const Pose& to, double h,
                  BodyState& state) noexcept;

}  // namespace palpate
