#pragma once

#include <algorithm>

#include "common/math/rotation.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

/// A tool that is a frame B, and its candidate step [v; phi].
struct FrameTool {
  int number = -1;  ///< of the tool; negative: B is none, and its motion is known
  Vec3 v = Vec3::Zero(), phi = Vec3::Zero();
  Vec3 c = Vec3::Zero();  ///< from its reference point to the other's at the candidate's end, in W
};

/// How a frame B moves in W in a sub-step, and with it the relative motion of a tool that makes the
/// step [v; phi] in W.  The translation is exact for every step; the rotation is, to first order.
///
/// B may be another tool, which makes a candidate step [v_b; phi_b] that the solver is to change.
/// Then the relative motion is that for this step, and its derivatives are those there: with c the
/// vector from B's reference point to the tool's at the candidate's end,
///   R_to d v_B = d v - d v_b - d phi_b x c,     R_from d phi_B = d phi - d phi_b.
class FrameMotion {
 public:
  FrameMotion() = default;  ///< B is W
  /// @param from, to  X_WB before and after the sub-step.   @param p_W  tool's reference point
  /// @param turns     false for a ball, whose rotation counts nowhere
  /// @param tool      the tool that B is, if it is one
  FrameMotion(const Pose& from, const Pose& to, const Vec3& p_W, bool turns,
              const FrameTool& tool = {})
      : is_W_(false),
        tool_(tool),
        from_(from.q.toRotationMatrix()),
        to_(to.q.toRotationMatrix()),
        turned_(turns ? Quat(to.q.conjugate() * from.q) : Quat::Identity()),
        v_(to.Inverse() * p_W - from.Inverse() * p_W),
        phi_(RotationLog(turned_)),
        spin_(RotationLog(to.q * from.q.conjugate())) {}

  bool is_W() const { return is_W_; }
  /// Returns what B's motion adds to a row of the tool, n . v + m . phi, in W.
  ContactRows::Other OtherOf(const Vec3& n, const Vec3& m) const {
    return {tool_.number, -n, -m - tool_.c.cross(n)};
  }
  /// Returns what that is at B's candidate step [m].
  double AtCandidate(const ContactRows::Other& other) const {
    return other.v.dot(tool_.v) + other.phi.dot(tool_.phi);
  }
  bool is_tool() const { return tool_.number >= 0; }
  /// Returns whether B moves.
  bool moves() const { return !v_.isZero(0.0) || !phi_.isZero(0.0); }
  /// The tool's motion in B [m], [rad].
  Vec3 v(const Vec3& v_W) const { return is_W_ ? v_W : Vec3(to_.transpose() * v_W + v_); }
  Vec3 phi(const Vec3& phi_W) const {
    return is_W_ ? phi_W : RotationLog(turned_ * RotationExp(from_.transpose() * phi_W));
  }
  /// What of them B's own motion is.
  const Vec3& own_v() const { return v_; }
  const Vec3& own_phi() const { return phi_; }
  /// The motion of the body's point at a lever from the tool's reference point, in W [m]: to first
  /// order in its rotation, as the tool's own; and what is beyond that.
  Vec3 BodyAt(const Vec3& lever_W) const { return spin_.cross(lever_W) - to_ * v_; }
  Vec3 BendAt(const Vec3& lever_W) const {
    return to_ * (from_.transpose() * lever_W) - lever_W - spin_.cross(lever_W);
  }
  /// R_WB for directions of translation and of rotation.
  const Mat3& R_v() const { return to_; }
  const Mat3& R_phi() const { return from_; }

 private:
  bool is_W_ = true;
  FrameTool tool_;
  Mat3 from_ = Mat3::Identity(), to_ = Mat3::Identity();
  Quat turned_ = Quat::Identity();
  Vec3 v_ = Vec3::Zero(), phi_ = Vec3::Zero();
  Vec3 spin_ = Vec3::Zero();  ///< of B in W, in which a ball's phi_ does not take part
};

/// The rows of a sub-step, seen from a frame B: what goes in and comes out is in B, and of the
/// motion in B; what is stored is in W, and of the tool's step.  With v_B = R^T v + v_0 and phi_B =
/// R^T phi + phi_0 (FrameMotion),
///   n_B . v_B + m_B . phi_B >= -g_B   becomes   (R n_B) . v + (R m_B) . phi >= -(g_B + n_B . v_0 +
///   m_B . phi_0),
/// and if B is a tool, the row names it, too.
class FrameRows {
 public:
  explicit FrameRows(ContactRows& rows) : rows_(rows) {}
  FrameRows(ContactRows& rows, const FrameMotion& motion) : rows_(rows), motion_(&motion) {}

  int count() const { return rows_.count(); }
  int max_rows() const { return rows_.max_rows(); }
  const ContactId& id(int row) const { return rows_.id(row); }
  bool IsLoose(int row) const { return rows_.IsLoose(row); }
  void Loosen(int row) noexcept { rows_.Loosen(row); }

  Vec3 normal(int row) const { return In(motion_->R_v(), rows_.normal(row)); }
  Vec3 lever(int row) const { return In(motion_->R_phi(), rows_.lever(row)); }
  double gap(int row) const { return rows_.gap(row) - Own(row); }
  void SetGap(int row, double gap) noexcept { rows_.SetGap(row, gap + Own(row)); }
  double Left(int row, const Vec3& v, const Vec3& phi) const {
    return gap(row) + normal(row).dot(v) + by_rotation(row).dot(phi);
  }
  double AngleTo(int row, const Vec3& n, const Vec3& by_rotation) const {
    const Vec3 n_W = Out(motion_->R_v(), n), by_rotation_W = Out(motion_->R_phi(), by_rotation);
    const double angle = rows_.AngleTo(row, n_W, by_rotation_W);
    if (!motion_->is_tool()) return angle;
    return std::max(angle, rows_.AngleTo(row, motion_->OtherOf(n_W, by_rotation_W)));
  }
  void AddRow(const Vec3& n, const Vec3& lever, double gap, const ContactId& id) noexcept {
    const int row = rows_.count();
    rows_.AddRow(n, lever, gap, id);
    if (rows_.with_others()) rows_.SetOther(row, {});
    if (!motion_->is_W()) SetRow(row, n, lever, lever.cross(n), gap);
  }
  void SetRow(int row, const Vec3& n, const Vec3& lever, const Vec3& by_rotation,
              double gap) noexcept {
    const Vec3 n_W = Out(motion_->R_v(), n), by_rotation_W = Out(motion_->R_phi(), by_rotation);
    double own = Own(n, by_rotation);
    if (motion_->is_tool()) {
      rows_.SetOther(row, motion_->OtherOf(n_W, by_rotation_W));
      own -= motion_->AtCandidate(rows_.other(row));
    }
    rows_.SetRow(row, n_W, Out(motion_->R_phi(), lever), by_rotation_W, gap + own);
  }

 private:
  Vec3 In(const Mat3& R, const Vec3& x) const { return motion_->is_W() ? x : R.transpose() * x; }
  Vec3 Out(const Mat3& R, const Vec3& x) const { return motion_->is_W() ? x : R * x; }
  Vec3 by_rotation(int row) const { return In(motion_->R_phi(), rows_.lever_cross_normal(row)); }
  double Own(const Vec3& n, const Vec3& by_rotation) const {
    if (motion_->is_W()) return 0.0;
    return n.dot(motion_->own_v()) + by_rotation.dot(motion_->own_phi());
  }
  double Own(int row) const {
    if (motion_->is_W()) return 0.0;
    const double own = Own(normal(row), by_rotation(row));
    return motion_->is_tool() ? own - motion_->AtCandidate(rows_.other(row)) : own;
  }

  static inline const FrameMotion kStill{};
  ContactRows& rows_;
  const FrameMotion* motion_ = &kStill;
};

}  // namespace palpate
