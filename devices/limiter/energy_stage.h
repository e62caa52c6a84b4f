#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "devices/limiter/stages.h"
#include "devices/limiter/wrench_limits.h"

namespace palpate {

/// Displacement of the handle between two calls, in W: of its origin [m], and the rotation
/// vector [rad].
struct Way {
  Vec3 p = Vec3::Zero();
  Vec3 phi = Vec3::Zero();
};

/// Measures the energy exchanged at the handle, in the time domain.  A device holds a commanded
/// wrench until the next command, so the work of each tick is exactly the held wrench times the
/// displacement, whatever the clock says (Hannaford & Ryu, "Time-domain passivity control of haptic
/// interfaces", IEEE T. Robotics and Automation 18 (2002) 1-10; that the observer of a held force
/// has no discretisation error: Ryu, Kim & Hannaford, IEEE T. Robotics 20 (2004) 772-776).
/// Positive: the hand has put in more than it got back.
/// Real-time; deterministic.
class PassivityObserver {
 public:
  /// A larger displacement in one call is not a hand's motion (5 m/s for 10 ms), but a clutch or an
  /// encoder that lost count.  No work is counted for it.
  static constexpr double kLeap_m = 0.05;
  static constexpr double kLeap_rad = 0.5;

  /// Counts and returns the hand's work since the last call, against the wrench held meanwhile [J].
  double Move(const Pose& X_WH) noexcept;
  /// Sets the wrench that the device holds from now on.
  void Hold(const Wrench& applied) noexcept { held_ = applied; }

  /// Returns false if the last pose was invalid: not finite, or no rotation.
  bool seen() const noexcept { return seen_; }
  /// Returns true if the last pose was the first, or was reached by a jump.
  bool leapt() const noexcept { return leapt_; }
  const Way& way() const noexcept { return way_; }
  double energy_J() const noexcept { return energy_J_; }
  double lowest_J() const noexcept { return lowest_J_; }

 private:
  Pose last_;
  bool has_last_ = false;
  bool seen_ = false;
  bool leapt_ = true;
  Way way_;
  Wrench held_;
  double energy_J_ = 0.0;
  double lowest_J_ = 0.0;
};

/// Gives the hand no more energy than it has put in: a passivity observer and an energy store, by
/// which the rendered wrench is scaled.
///
/// The store is the energy that the hand has put in and not got back, limited to what a contact can
/// store: a force f that grew from zero over at most kDeepest_m stores at most f kDeepest_m / 2.
/// Any excess is forgotten within kForget_s.  Heat from friction and earlier contacts therefore
/// give no credit, and in free space there is none at all, so that a long passive phase cannot hide
/// an active one (the resets of Hannaford & Ryu 2002, made continuous).
///
/// The wrench is scaled by one factor, which keeps its line of action.  Two rules give the factor:
///   reference  store / stored while the hand moves out, if the coupling's spring stores
///              `stored` = f^2 / 2k and the store holds less.  A force that is held for a tick, or
///              is late, costs a share of the energy at each release; this spreads the cost evenly
///              over the release, so that the force does not break off at its end (a reference
///              energy, as in Ryu, Preusche, Hannaford & Hirzinger, IEEE T. Control Systems
///              Technology 13 (2005) 737-742; here it is the least energy that the spring must
///              store)
///   bound      such that the store suffices for the next tick and for the ticks in which the slew
///              limit reduces the force, even if the handle accelerates outwards all the while, by
///              kHandAccel and by the force on kLeastMass
/// Neither factor divides by a velocity, so encoder noise at rest is not amplified (the problem
/// that Ryu, Journal of Control, Automation and Systems Engineering 12 (2006) 380-388, solves for
/// the classical damper); energy tanks, too, scale instead of damping (Franken, Stramigioli, Misra,
/// Secchi & Macchelli, IEEE T. Robotics 27 (2011) 741-756).
///
/// So the hand gets at most kSeed_J more than it has put in.  Once it has put in twice that, the
/// seed is taken back, and it gets nothing more than it has put in.  This holds while no tick's
/// displacement exceeds the last one by more than the bound foresees (a hand in debt that turns
/// round faster while it moves in gets one seed each time).  A handle that has not moved since
/// forces came on has done no work, and feels the whole force; the first tick of its motion is
/// on credit.
///
/// README.md says what this costs a light touch at rest, and why a lower acceleration is not
/// assumed. The bound assumes the average length of ticks and not that of the last one: if the
/// machine now and then delays a tick, expecting the same of the next would reduce the force
/// without need.
///
/// A hand may already be in contact when forces come on, or return after a silence.  It has no
/// remembered credit, and without a force it could not put in energy.  While its force ramps in,
/// the store is therefore filled up to the energy of the coupling, f^2 / 2k, in total at most its
/// greatest value: 12 mJ for 5 N at 1 N/mm, once per ramp from zero.  Until the hand leaves that
/// contact, it gets the same credit whenever it rests, within two encoder steps for kRest_s: it
/// then holds the spring in equilibrium, and a loop that generates energy does not rest.  Nothing
/// is granted if the stiffness is unknown.
///
/// The server decides when a force begins, how great it is and how stiff its spring is, and it need
/// not be right.  So all grants are drawn from one budget, which only the energy that the store
/// forgets refills: energy that the hand has put in and will not get back, or that was granted and
/// not used. Each tick's work changes the store alone, so that
///   store + budget <= kBudget_J + all energy that the hand has put in and not got back,
/// and a server that restarts forces again and again, or is silent in between, gives the hand
/// kBudget_J in total, and not each time.  A hand that rests in an object while its server restarts
/// gets its force back every time.
///
/// The energy is measured at the hand: if a workspace scales the tool's motion by `scale`
/// (DeviceInfo::motion_scale), displacements and torques are divided by it first.
///
/// Real-time; deterministic.
class EnergyStage {
 public:
  static constexpr double kDeepest_m = 0.025;
  static constexpr double kDeepest_rad = 0.25;
  static constexpr double kForget_s = 0.05;
  static constexpr double kRest_s = 0.2;
  /// The acceleration that a hand may give the handle by itself, and the least mass that a force
  /// moves: that of a hand on an arm.
  static constexpr double kHandAccel_m_s2 = 40.0;
  static constexpr double kLeastMass_kg = 0.7;
  /// That of 0.5 N m on 1.3 g m^2.
  static constexpr double kMostAccel_rad_s2 = 400.0;
  /// Energy rendered on credit: 0.05 N, which cannot be felt, over an unforeseen 60 um.  At the
  /// start of a contact it lets the store grow, by a share with each encoder step.
  static constexpr double kSeed_J = 3e-6;
  /// The most that can be granted while the hand puts in nothing: the energy of 10 N at 1 N/mm, or
  /// of four contacts of 5 N that the hand was in before their force began.  It accelerates a hand
  /// of 0.7 kg to 0.4 m/s.
  static constexpr double kBudget_J = 0.05;
  /// Reserve that is never spent: the seed, and a little for rounding.
  static constexpr double kReserve_J = 1.01 * kSeed_J;
  /// The first rule (reference) sets in at kStill and applies in full from kMoving on.  The speed
  /// is smoothed over kSmooth_s, so that single encoder steps to and fro do not count.
  static constexpr double kStill_m_s = 0.004;
  static constexpr double kMoving_m_s = 0.014;
  static constexpr double kSmooth_s = 0.015;
  /// Time over which the length of a tick is smoothed.
  static constexpr double kTick_s = 0.05;
  /// Smoothed speed above which the hand counts as moving in, even if it moves less than an encoder
  /// step per tick.
  static constexpr double kInwards_m_s = 0.002;

  explicit EnergyStage(const WrenchLimits& limits);

  /// Sets the stiffness of the spring between hand and scene [N/m], which tells the energy that a
  /// force must have stored.  If it is infinite or NaN, the stiffness is unknown, and the first
  /// rule does not act.
  void SetStiffness(double N_per_m) noexcept {
    compliance_ = N_per_m > 0.0 ? 1.0 / (scale_ * N_per_m) : 0.0;
  }

  /// @param asked   the slewed wrench; it, X_WT and the result are those of the tool.
  /// @param gain  product of the later stages' factors, in [0, 1].
  /// @param felt    as for SlewStage::Pass.
  /// @param entering  true during a ramp from zero.
  /// @param dt_s    since the last call.
  /// @param X_WT    also gives the velocity; the driver's own is not trusted.
  Wrench Pass(const Wrench& asked, double gain, const Pose& X_WT, double dt_s, bool felt = true,
              bool entering = false) noexcept;
  /// Sets the part of the result that the device finally holds, after the gains.
  void Hold(const Wrench& applied) noexcept { observer_.Hold(AtTheHand(applied)); }

  /// Number of calls in which the stage reduced the wrench.
  std::uint64_t count() const noexcept { return count_; }
  /// Energy that was granted and is not back in the budget [J].
  double lent_J() const noexcept { return kBudget_J - budget_J_; }
  const PassivityObserver& observer() const noexcept { return observer_; }
  double store_J() const noexcept { return store_J_; }

 private:
  Wrench AtTheHand(const Wrench& w) const noexcept { return {w.force, w.torque / scale_}; }
  void Settle(double most_J, double dt_s) noexcept;
  /// @param stored_J  energy that the coupling stores for the wanted wrench, after the gain.
  void Grant(double stored_J, bool entering) noexcept;
  /// Moves energy from the budget into the store, as far as there is any; returns how much.
  double Draw(double wanted_J) noexcept;
  bool Rests(const Pose& X_WH, double dt_s) noexcept;
  /// @param foreseen  work of the wanted wrench over a displacement like the last one [J].
  double Factor(const Wrench& wanted, double foreseen, double gain) const noexcept;

  PassivityObserver observer_;
  double store_J_ = 0.0;
  double budget_J_ = kBudget_J;
  double entry_most_J_ = 0.0, entry_granted_J_ = 0.0;  // of the present ramp
  Pose X_rest_;                                        // where the hand rests
  double rest_s_ = 0.0;                                // ... and for how long [s]
  bool inside_ = false;         // the hand was in this contact when its force began
  bool moved_ = false;          // against or along what it held
  bool repaid_ = false;         // true once the seed was taken back
  Vec3 smooth_ = Vec3::Zero();  // velocity [m/s]
  double tick_s_ = 0.0;         // smoothed
  int inwards_ = 0;             // number of successive calls in which the handle moved in
  SlewStage slew_;              // the store's limit may jump; the rendered wrench does not
  double scale_;                // motion of the tool over motion of the hand
  double position_resolution_m_, rotation_resolution_rad_;
  double compliance_ = 0.0;  // of the coupling [m/N]
  std::uint64_t count_ = 0;
};

}  // namespace palpate
