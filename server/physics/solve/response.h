#pragma once

#include "common/math/pose.h"

namespace palpate {

/// The pose of the haptic tool relative to the graphic tool: the target of the step (xi_h, chapter
/// 2.3).
/// @field v    p_H - p_G of the reference points [m], in W.
/// @field phi  Log(R_H R_G^T) [rad], in W.
struct Target {
  Vec3 v = Vec3::Zero();
  Vec3 phi = Vec3::Zero();
};

/// Returns the target of the graphic tool at (p_G, q_G) for the haptic tool at (p_H, q_H), with
/// reference points in W.  The chapter's Euler angles (2.14, 2.22) are singular at beta = 90
/// degrees and weight rotations unevenly; the rotation vector does neither, and agrees with
/// them to second order.
Target TargetOf(const Vec3& p_G, const Quat& q_G, const Vec3& p_H, const Quat& q_H) noexcept;

/// TargetOf with a phi that continues past half a turn, up to a full one (RotationLogFrom).
/// @param rotation_G  of the last call, in the graphic tool's frame; zero on the first; updated.
Target TargetFrom(const Vec3& p_G, const Quat& q_G, const Vec3& p_H, const Quat& q_H,
                  Vec3& rotation_G) noexcept;

/// Returns the wrench of the spring between the tools after the graphic tool takes the step [v;
/// phi] towards the target (chapter 2.20-2.24): F = k_t (p_G - p_H), tau = k_r Log(R_G R_H^T), in
/// W, on the hand.  The rotation continues past half a turn as the target's does.
Wrench SpringWrench(const Target& target, const Vec3& v, const Vec3& phi, double stiffness,
                    double torsional_stiffness) noexcept;

}  // namespace palpate
