#pragma once

#include <cstdint>

#include "client/station/reply.h"

namespace palpate {

/// The spring of a session between hand and graphic tool (SessionState), and where it acts.
struct CouplingSpring {
  double stiffness = 0.0;            ///< [N/m]; 0: not known
  double torsional_stiffness = 0.0;  ///< [N m/rad]
  Vec3 reference = Vec3::Zero();     ///< the tool's reference point, in the tool's frame [m]
};

/// What the newest reply says of a pose that it does not answer: its rows are the walls that the
/// server's step met, and the device's newest pose is held against them here, so that a force is
/// late by a tick and not by a round trip.
///
/// The step xi = [v; phi] of the graphic tool from the reply's X_WG is the server's own problem
/// (server/physics/README.md, One cycle) with the reply's rows for all rows:
///   minimise |x - x_h|^2 / 2 subject to the rows,  x = [v; rho phi],  rho = sqrt(k_r / k_t),
/// and the wrench is the spring's between that step and the hand.  Added to it is what the rows did
/// not explain at the pose that the reply answers (friction, and what rounds): there the wrench is
/// the reply's.  Elsewhere that remainder goes down with the spring's stretch, as friction does
/// with the normal force, and never up.
///
/// What it remembers in free space, how far rows are believed, and why nothing jumps: README.md.
/// Rows hold for steps within region_m and region_rad of the one that the server made (of the place
/// where it touched last, for a tool that is free), and until valid_s from the pose that they
/// answer; beyond, the wrench fades to nothing over once more that region or time.
///
/// Replies lie as far as this class knows.  Rows that no step can have made (not finite, no unit
/// normals, a tool well inside, too many, a wrench that they do not explain) count as none; then,
/// and where the server gives none because not all that pushes is a row, the wrench is the reply's,
/// as it came.  The wrench of a reply is given on where it is not finite: WrenchLimiter's first
/// stage is for that.
///
/// Thread contract: one thread.  Real-time: no allocation, lock, log or clock.  Deterministic.
class LocalContactModel {
 public:
  static constexpr double kBlend_s = 0.001;

  /// False: the wrench is the newest reply's, as it came.
  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }
  void SetSpring(const CouplingSpring& spring) noexcept;
  /// A session is over: what was touched in it is no wall of the next one.
  void Forget() noexcept { has_touched_ = false; }
  /// Takes the newest reply.
  /// @param X_WH  the handle at the pose that it answers.
  void Take(const Reply& reply, const Pose& X_WH) noexcept;

  struct Evaluation {
    Wrench wrench;               ///< on the hand, at the tool's reference point, in W
    bool evaluated = false;      ///< by rows
    bool beyond_region = false;  ///< of the newest reply's rows: the wrench fades
  };
  /// The wrench for the handle's newest pose.  Zero before the first reply.
  Evaluation At(std::int64_t now_ns, const Pose& X_WH) noexcept;

 private:
  /// The nearest step that the rows allow, and the spring's wrench there.
  struct Step {
    Vec3 v = Vec3::Zero(), phi = Vec3::Zero();
    Wrench wrench;             ///< zero, exactly, where no row holds the tool
    double stretch = 0.0;      ///< of the spring, |x - x_h| [m]
    Vec3 turn = Vec3::Zero();  ///< of the hand from the graphic tool (RotationLogFrom)
  };
  /// A reply, checked.
  struct Contact {
    Reply reply;
    bool has_rows = false;
    Step answered;                              ///< at the pose that the reply answers
    Vec3 v = Vec3::Zero(), phi = Vec3::Zero();  ///< the step around which the rows hold
    Wrench remainder;                           ///< what the rows do not explain there
  };

  bool Usable(const Reply& reply) const noexcept;
  void Remember(Contact& contact) noexcept;
  Step Solve(const Reply& reply, const Pose& X_WH, const Vec3& turn) const noexcept;
  Evaluation Evaluate(const Contact& contact, std::int64_t now_ns, const Pose& X_WH) const noexcept;

  bool enabled_ = true;
  CouplingSpring spring_;
  double rho_ = 1.0;
  Contact contact_;  // what At goes by
  Contact next_;     // what it is to go by
  bool has_next_ = false;
  Reply touched_;  // the last that had usable rows
  bool has_touched_ = false;
  Wrench blend_;  // added to the newest contact's wrench, on its way to nothing
  std::int64_t last_ns_ = 0;
};

}  // namespace palpate
