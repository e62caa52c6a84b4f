#pragma once

#include <cstdint>

#include "client/station/reply.h"

namespace palpate {

/// A session's spring between hand and graphic tool (SessionState), and the point where it acts.
struct CouplingSpring {
  double stiffness = 0.0;            ///< [N/m]; 0: not known
  double torsional_stiffness = 0.0;  ///< [N m/rad]
  Vec3 reference = Vec3::Zero();     ///< the tool's reference point, in the tool's frame [m]
};

/// Evaluates the newest reply's contacts at poses that the reply does not answer.  The reply's rows
/// are the walls that the server's step met; the station applies them to the device's newest pose,
/// so that the force lags by a tick and not by a round trip.
///
/// The step xi = [v; phi] of the graphic tool from the reply's X_WG solves the server's own problem
/// (server/physics/README.md, One cycle), restricted to the reply's rows:
///   minimise |x - x_h|^2 / 2 subject to the rows,  x = [v; rho phi],  rho = sqrt(k_r / k_t),
/// and the wrench is the spring's between that step and the hand.  Added to it is the remainder:
/// the part of the reply's wrench that the rows do not explain at the pose that it answers
/// (friction and rounding), so that there the wrench equals the reply's.  Elsewhere the
/// remainder decreases with the spring's stretch, as friction does with the normal force, and
/// never increases.
///
/// README.md says what the model remembers in free space, how far rows are trusted, and why no
/// force jumps.  Rows hold for steps within region_m and region_rad of the server's own step (for a
/// free tool, of the place of the last contact), and until valid_s after the pose that they answer;
/// beyond, the wrench fades to zero over the same region or time again.
///
/// Replies are not trusted.  Rows that no valid step can produce (not finite, normals not of unit
/// length, a tool well inside, too many, a wrench that they do not explain) are ignored.  Then, and
/// when the server gives no rows because not every contact is a row, the wrench is the reply's,
/// unchanged.  A wrench that is not finite is passed on: WrenchLimiter's first stage handles it.
///
/// Thread contract: one thread.  Real-time: no allocation, lock, log or clock.  Deterministic.
class LocalContactModel {
 public:
  static constexpr double kBlend_s = 0.001;

  /// Switches the model on or off; when off, the wrench is the newest reply's, unchanged.
  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }
  void SetSpring(const CouplingSpring& spring) noexcept;
  /// Ends a session: its contacts are no walls of the next one.
  void Forget() noexcept { has_touched_ = false; }
  /// Takes the newest reply.
  /// @param X_WH  the handle's pose that the reply answers.
  void Take(const Reply& reply, const Pose& X_WH) noexcept;

  struct Evaluation {
    Wrench wrench;           ///< on the hand, at the tool's reference point, in W
    bool evaluated = false;  ///< computed from rows
    /// Outside the region of the newest reply's rows: the wrench fades.
    bool beyond_region = false;
  };
  /// Returns the wrench for the handle's newest pose.  Zero before the first reply.
  Evaluation At(std::int64_t now_ns, const Pose& X_WH) noexcept;

 private:
  /// The nearest step that the rows allow, and the spring's wrench there.
  struct Step {
    Vec3 v = Vec3::Zero(), phi = Vec3::Zero();
    Wrench wrench;             ///< exactly zero if no row holds the tool
    double stretch = 0.0;      ///< of the spring, |x - x_h| [m]
    Vec3 turn = Vec3::Zero();  ///< of the hand from the graphic tool (RotationLogFrom)
  };
  /// A checked reply.
  struct Contact {
    Reply reply;
    bool has_rows = false;
    Step answered;                              ///< at the pose that the reply answers
    Vec3 v = Vec3::Zero(), phi = Vec3::Zero();  ///< the step around which the rows hold
    Wrench remainder;  ///< the part of the wrench there that the rows do not explain
  };

  bool Usable(const Reply& reply) const noexcept;
  void Remember(Contact& contact) noexcept;
  Step Solve(const Reply& reply, const Pose& X_WH, const Vec3& turn) const noexcept;
  Evaluation Evaluate(const Contact& contact, std::int64_t now_ns, const Pose& X_WH) const noexcept;

  bool enabled_ = true;
  CouplingSpring spring_;
  double rho_ = 1.0;
  Contact contact_;  // used by At
  Contact next_;     // to be used next
  bool has_next_ = false;
  Reply touched_;  // the last reply that had usable rows
  bool has_touched_ = false;
  Wrench blend_;  // added to the newest contact's wrench; decays to zero
  std::int64_t last_ns_ = 0;
};

}  // namespace palpate
