#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// Pose X_AB of frame B in frame A: a point with coordinates p_B in B has p_A = q * p_B + p in A.
/// @field p  position of B's origin, in A [m].
/// @field q  rotation of B in A, unit quaternion; q and -q are the same pose.
struct Pose {
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();

  Vec3 operator*(const Vec3& p_B) const { return q * p_B + p; }
  /// X_AC = X_AB * X_BC.
  Pose operator*(const Pose& X_BC) const { return {q * X_BC.p + p, (q * X_BC.q).normalized()}; }
  Pose Inverse() const { return {q.conjugate() * -p, q.conjugate()}; }
};

/// Spatial velocity of a body: v of its reference point [m/s] and w [rad/s], both in W.
struct Twist {
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
};

/// Force [N] on a body at its reference point and torque [N m] about that point, both in W.
struct Wrench {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
};

}  // namespace palpate
