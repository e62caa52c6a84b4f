#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "devices/limiter/stages.h"
#include "devices/limiter/wrench_limits.h"

namespace palpate {

/// Way of the handle between two calls, in W: of its origin [m], and the rotation vector [rad].
struct Way {
  Vec3 p = Vec3::Zero();
  Vec3 phi = Vec3::Zero();
};

/// Keeps the account of the energy at the handle, in the time domain: a device holds what it was
/// told until it is told anew, so the work of each tick is what was held . the way that was made,
/// exactly, whatever the clock says (Hannaford & Ryu, "Time-domain passivity control of haptic
/// interfaces", IEEE T. Robotics and Automation 18 (2002) 1-10; that the observer of a held force
/// has no discretisation error: Ryu, Kim & Hannaford, IEEE T. Robotics 20 (2004) 772-776).
/// Positive: the hand has put in more than it got back.
/// Real-time; deterministic.
class PassivityObserver {
 public:
  /// Further than this in one call is not a motion of a hand (5 m/s for 10 ms): a clutch, or an
  /// encoder that lost count.  No work is booked for it.
  static constexpr double kLeap_m = 0.05;
  static constexpr double kLeap_rad = 0.5;

  /// Settles what was held since the last call.  Returns the work that the hand did [J].
  double Move(const Pose& X_WH) noexcept;
  /// What the device holds from now on.
  void Hold(const Wrench& applied) noexcept { held_ = applied; }

  /// False where the last pose was none: not finite, or no rotation.
  bool seen() const noexcept { return seen_; }
  /// True where the last pose was the first, or was reached by a leap.
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

/// Gives the hand no more energy than it has put in: a passivity observer, and a store that scales
/// what is rendered.
///
/// The store is what the hand has put in and not got back, as far as a contact could hold it: a
/// force f that grew from nothing over a way of at most kDeepest_m holds at most f kDeepest_m / 2.
/// What is beyond that is forgotten within kForget_s: friction's heat and the past of another
/// contact are no credit, and in free space there is none at all, so that a long passive phase
/// cannot hide an active one (the resets of Hannaford & Ryu 2002, made continuous).
///
/// The wrench is scaled, by one factor, so its line of action stays:
///   reference  while the hand moves out, by store / stored, where the coupling's spring holds
///              `stored` = f^2 / 2k and the store has less.  A force that is held for a tick, or
///              comes late, costs a share of each release; so it is paid evenly along the release,
///              not by a force that breaks off at its end (a reference energy, as in Ryu, Preusche,
///              Hannaford & Hirzinger, IEEE T. Control Systems Technology 13 (2005) 737-742; here
///              it is the least that the spring must hold)
///   bound      so far that the store outlasts the next tick, and the ticks in which the slew limit
///              lets the force go, though the handle accelerates outwards all the while, by
///              kHandAccel and by what the force does to kLeastMass
/// No factor is divided by a velocity, so encoder noise at rest is not amplified (what Ryu, Journal
/// of Control, Automation and Systems Engineering 12 (2006) 380-388, cures in the classical
/// damper); scaling instead of damping is that of energy tanks (Franken, Stramigioli, Misra, Secchi
/// & Macchelli, IEEE T. Robotics 27 (2011) 741-756).
///
/// So the hand is given at most kSeed_J more than it has put in; and nothing more once it has put
/// in twice that, when the seed is taken back: then the sum stays at or below zero.  That holds
/// while no tick's way exceeds the last one by more than the bound foresees (a hand in debt that
/// turns round faster than that, in the middle of moving in, is given one seed each time).  A
/// handle that has not moved since forces came on has done no work, and feels the whole force: of
/// it the first tick is owed.
///
/// What that costs a light touch at rest, and why the acceleration is not taken for less:
/// README.md. A tick is taken for as long as ticks are, not as the last one was: where a machine
/// now and then holds one up, foreseeing as much for the next lets a force go that nothing asks
/// for.
///
/// A hand may be in a contact before forces come on, or when they come back after a silence: it has
/// put in nothing that is remembered, and without a force it could put in nothing.  While such a
/// hand's force comes in by a ramp, the store is therefore filled up to what the coupling then
/// holds, f^2 / 2k, and in all by no more than the greatest of that: 12 mJ for 5 N at 1 N/mm, once
/// for each ramp from zero.  Until it leaves that contact, it is also credited with as much
/// whenever it rests, within two steps of its encoder for kRest_s: it holds the spring as it
/// stands, and a loop that gives energy does not rest.  Where the stiffness is not known nothing is
/// granted.
///
/// When a force begins, how great it is and how stiff its spring, is the server's word.  So all
/// that is granted is drawn from one budget, which is refilled by what the store forgets and by
/// nothing else: by energy that the hand put in and will not get back, or that was granted and not
/// used.  Each tick's work moves the store alone, so that
///   store + budget <= kBudget_J + all that the hand has put in and not got back,
/// and a server that begins again and again, or is silent in between, gives the hand kBudget_J in
/// all, and not each time.  A hand that rests in an object while its server is started anew gets
/// its force back however often that is.
///
/// The account is that of the hand: where a workspace makes the tool's way `scale` times as long
/// (DeviceInfo::motion_scale), ways and torques are divided by that before they are booked.
///
/// Real-time; deterministic.
class EnergyStage {
 public:
  static constexpr double kDeepest_m = 0.025;
  static constexpr double kDeepest_rad = 0.25;
  static constexpr double kForget_s = 0.05;
  static constexpr double kRest_s = 0.2;
  /// What a hand may do of itself, and the mass that a force moves: that of a hand on an arm.
  static constexpr double kHandAccel_m_s2 = 40.0;
  static constexpr double kLeastMass_kg = 0.7;
  /// 0.5 N m on 1.3 g m^2.
  static constexpr double kMostAccel_rad_s2 = 400.0;
  /// Rendered on credit: 0.05 N, which nobody feels, over an unforeseen 60 um.  From it a store
  /// grows where a contact begins, by a share with each way of the encoder's step.
  static constexpr double kSeed_J = 3e-6;
  /// Most that can be granted while the hand puts in nothing: 10 N at 1 N/mm, or four contacts of
  /// 5 N that it was in before their force began.  A hand of 0.7 kg leaves at 0.4 m/s.
  static constexpr double kBudget_J = 0.05;
  /// Kept back in the end: the seed, and some for rounding.
  static constexpr double kReserve_J = 1.01 * kSeed_J;
  /// The first rule counts from the one speed on, and in full from the other; the speed is
  /// smoothed, so that it is not an encoder's step to and fro that counts.
  static constexpr double kStill_m_s = 0.004;
  static constexpr double kMoving_m_s = 0.014;
  static constexpr double kSmooth_s = 0.015;
  /// Over which the length of a tick is smoothed.
  static constexpr double kTick_s = 0.05;
  /// Smoothed, too: slower than an encoder's step each tick, a hand does move in.
  static constexpr double kInwards_m_s = 0.002;

  explicit EnergyStage(const WrenchLimits& limits);

  /// Stiffness of the spring between hand and scene [N/m]: what a force must have stored. Infinite,
  /// or no number: not known, and the first rule does not act.
  void SetStiffness(double N_per_m) noexcept {
    compliance_ = N_per_m > 0.0 ? 1.0 / (scale_ * N_per_m) : 0.0;
  }

  /// @param asked   slewed; it, X_WT and what is returned are the tool's.  @param gain  of the
  /// stages that follow, in [0, 1].
  /// @param felt    as SlewStage::Pass.   @param entering  a ramp from zero is on its way.
  /// @param X_WT    tells the velocity, too: what a driver says of it is not relied on.
  Wrench Pass(const Wrench& asked, double gain, const Pose& X_WT, double dt_s, bool felt = true,
              bool entering = false) noexcept;
  /// What of it the device holds in the end, after the gains.
  void Hold(const Wrench& applied) noexcept { observer_.Hold(AtTheHand(applied)); }

  /// Calls in which it held something back.
  std::uint64_t count() const noexcept { return count_; }
  /// What has been granted, and is not back in the budget [J].
  double lent_J() const noexcept { return kBudget_J - budget_J_; }
  const PassivityObserver& observer() const noexcept { return observer_; }
  double store_J() const noexcept { return store_J_; }

 private:
  Wrench AtTheHand(const Wrench& w) const noexcept { return {w.force, w.torque / scale_}; }
  void Settle(double most_J, double dt_s) noexcept;
  /// @param stored_J  what the coupling holds of the wanted wrench, after the gain.
  void Grant(double stored_J, bool entering) noexcept;
  /// From the budget into the store, as far as it goes; returns how much.
  double Draw(double wanted_J) noexcept;
  bool Rests(const Pose& X_WH, double dt_s) noexcept;
  /// @param foreseen  work of the wanted wrench over a way like the last [J].
  double Factor(const Wrench& wanted, double foreseen, double gain) const noexcept;

  PassivityObserver observer_;
  double store_J_ = 0.0;
  double budget_J_ = kBudget_J;
  double entry_most_J_ = 0.0, entry_granted_J_ = 0.0;  // of the ramp that is on its way
  Pose X_rest_;                                        // where the hand rests
  double rest_s_ = 0.0;                                // ... and for how long
  bool inside_ = false;         // the hand was in this contact when its force began
  bool moved_ = false;          // against or along what it held
  bool repaid_ = false;         // the seed
  Vec3 smooth_ = Vec3::Zero();  // velocity [m/s]
  double tick_s_ = 0.0;         // smoothed
  int inwards_ = 0;             // calls in a row in which the handle moved in
  SlewStage slew_;              // what the store allows may leap: what is rendered does not
  double scale_;                // way of the tool over way of the hand
  double position_resolution_m_, rotation_resolution_rad_;
  double compliance_ = 0.0;  // of the coupling [m/N]
  std::uint64_t count_ = 0;
};

}  // namespace palpate
