#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "client/station/guide.h"
#include "client/station/local_contact_model.h"
#include "client/station/pose_lead.h"
#include "client/station/reply.h"
#include "common/math/pose.h"
#include "common/realtime/histogram.h"
#include "devices/device.h"
#include "devices/wrench_limiter.h"

namespace palpate {

/// A pose to send.
struct OutgoingPose {
  std::uint64_t sequence = 0;
  std::int64_t sample_time_ns = 0;
  DeviceSample sample;  ///< as read from the device
  /// The pose to send in place of the sample's: with the local contact model on, the predicted pose
  /// of the hand when the reply arrives (PoseLead).
  Pose X_WH;
};

/// Counts and extremes of a station so far.
struct StationTotals {
  std::uint64_t ticks = 0;
  std::uint64_t sent = 0;
  std::uint64_t replies = 0;
  std::uint64_t strays = 0;  ///< replies to no sent pose, or out of order; not used
  std::uint64_t late = 0;    ///< replies that took more than 1 ms
  std::uint64_t contact_replies = 0;
  std::uint32_t max_contacts = 0;
  std::uint32_t faults = 0;              ///< union of all fault bits
  std::uint64_t device_faults = 0;       ///< how often the device fell from order into a fault
  std::uint64_t device_fault_ticks = 0;  ///< ticks at fault, those before it was ready among them
  double max_force_N = 0.0;              ///< applied to the device
  double max_torque_Nm = 0.0;
  std::uint64_t evaluations = 0;    ///< ticks whose wrench came from the local contact model's rows
  std::uint64_t beyond_region = 0;  ///< of these, ticks at which the rows were too far or too old
  Histogram round_trip;             ///< pose out to wrench in [ns]
  Histogram server_step;            ///< [ns]
};

/// The figures that a display shows; "of the period" means since the previous snapshot.
struct StationSnapshot {
  std::int64_t time_ns = 0;
  double rate_hz = 0.0;            ///< ticks, of the period
  double nominal_hz = 0.0;         ///< DeviceInfo::rate_Hz
  double round_trip_us_p50 = 0.0;  ///< of the period; zero if no reply came
  double round_trip_us_p99 = 0.0;
  double server_step_us_p50 = 0.0;
  std::uint64_t replies = 0;   ///< of the period
  std::uint32_t contacts = 0;  ///< of the latest reply
  std::uint32_t faults = 0;    ///< all bits of the period
  double force_N = 0.0;        ///< applied to the device at the end of the period
  double torque_Nm = 0.0;
  double peak_force_N = 0.0;  ///< of the period
  std::uint64_t sent = 0;     ///< from here on: totals, not of the period
  std::uint64_t late = 0;
  std::uint64_t lost = 0;  ///< poses without an answer, except those still in flight
  std::uint64_t fades = 0;
  bool fading = false;
  bool device_at_fault = false;  ///< at the end of the period
  const char* activity = "";     ///< Device::activity
  // Further figures for StationStatistics.
  std::uint64_t ticks = 0;            ///< of the period
  double silence_s_max = 0.0;         ///< of the period; valid after the first reply
  double wanted_force_N_max = 0.0;    ///< of the period: contact and guide, before the limiter
  double wanted_torque_Nm_max = 0.0;  ///< likewise
  double peak_torque_Nm = 0.0;        ///< of the period
  std::uint32_t status = 0;           ///< of the device: all bits of the period
  LimiterCounts limiter;              ///< since the start
  double energy_J = 0.0;              ///< WrenchLimiter::observer, since the start
  double energy_J_min = 0.0;
  double warmth = 0.0;  ///< WrenchLimiter::warmth
};

/// The station's servo loop without clock and transport: reads the device, returns the pose to
/// send, takes the replies, and drives the device through the limiter.  Time is an argument, so a
/// unit test can simulate a dying server.
/// Thread contract: one thread.
/// Real-time: no method allocates, locks, logs or reads a clock.
class StationCore {
 public:
  static constexpr std::int64_t kLate_ns = 1'000'000;
  /// Number of poses that a reply may answer: those of the last quarter of a second.
  static constexpr std::size_t kRemembered = 256;

  /// The server's own ramp ends within this time.
  static constexpr std::int64_t kEntry_ns = 300'000'000;
  /// A graphic tool that begins further than this from the hand began outside an object that the
  /// hand is inside of.
  static constexpr double kInside_m = 1e-5;

  /// The device must outlive the core.  Throws Error if the device has no limits.
  /// @param most_force_N  as in WrenchLimits::Of.
  explicit StationCore(Device& device,
                       double most_force_N = std::numeric_limits<double>::infinity());
  Device& device() noexcept { return device_; }

  void EnableForces(bool on) noexcept { forces_wanted_ = on; }
  /// While muted there are no forces, even if enabled.
  void Mute(bool on) noexcept { muted_ = on; }
  /// Sets the session's spring: the point where its wrench acts, and the stiffness for the local
  /// contact model and for the energy that a contact's force must have stored (EnergyStage).
  void SetSpring(const CouplingSpring& spring) noexcept;
  /// If on (the default), evaluates replies' rows at the newest pose; if off, applies their wrench
  /// unchanged and late.
  void EnableLocalModel(bool on) noexcept { local_model_.Enable(on); }

  /// Lets guides lead the hand within these limits.  Without this call no guide does.
  void AcceptGuide(const GuideLimits& limits) noexcept { guide_ = Guide(limits); }
  void Take(std::int64_t now_ns, const GuideAim& aim) noexcept { guide_.Take(now_ns, aim); }
  const Guide& guide() const noexcept { return guide_; }

  /// The session has ended: forgets the graphic tool.  Call it before Sense.
  void LoseSession() noexcept;
  /// First half of a tick: reads the device.  If `sending`, the pose gets the next sequence number;
  /// otherwise there is no session.
  OutgoingPose Sense(std::int64_t now_ns, bool sending) noexcept;
  /// Takes one of the replies that came since the last tick, oldest first.
  void Take(const Reply& reply) noexcept;
  /// Second half of a tick: drives the device with the newest reply, evaluated at the newest pose.
  void Act(std::int64_t now_ns) noexcept;

  /// Restarts the counts, for instance after a warm-up.
  void RestartTotals() noexcept;
  StationSnapshot TakeSnapshot(std::int64_t now_ns) noexcept;
  const StationTotals& totals() const noexcept { return totals_; }
  const WrenchLimiter& limiter() const noexcept { return limiter_; }
  /// Returns the limiter's last input.
  const LimiterInput& asked() const noexcept { return asked_; }
  std::uint64_t lost() const noexcept;
  /// False if the device was last told to render nothing at all.
  bool renders_force() const noexcept {
    return !applied_.force.isZero(0.0) || !applied_.torque.isZero(0.0);
  }
  /// Returns the newest reply that was used; its sequence is 0 before the first.
  const Reply& newest() const noexcept { return newest_; }
  /// Returns the sequence number of the newest pose.
  std::uint64_t sequence() const noexcept { return sequence_; }
  /// Returns the limiter's last output: at the handle, in W.
  const Wrench& applied() const noexcept { return applied_; }
  /// Returns when the pose of the newest reply was sampled; 0 before the first.
  std::int64_t newest_reply_ns() const noexcept { return newest_.pose_time_ns; }

 private:
  Device& device_;
  WrenchLimiter limiter_;
  Guide guide_;
  bool forces_wanted_ = false;
  bool muted_ = false;
  bool started_ = false;  // by the newest reply, the server's force has started
  std::int64_t entered_until_ns_ = 0;
  Vec3 tool_reference_ = Vec3::Zero();
  LocalContactModel local_model_;
  PoseLead lead_;
  LimiterInput asked_;
  DeviceSample sample_;
  Reply newest_;
  bool device_at_fault_ = true;  // until it is ready
  bool has_reply_ = false;
  bool graphic_known_ = false;  // in this session
  std::uint64_t sequence_ = 0;
  struct SentPose {
    std::int64_t time_ns = 0;
    Pose X_WH;  // as it was sent
  };
  std::array<SentPose, kRemembered> sent_;  // up to sequence_, by sequence number
  std::int64_t last_act_ns_ = 0;
  Wrench applied_;
  StationTotals totals_;
  std::uint64_t answered_before_ = 0;  // poses up to here do not belong to these totals

  // Of the period.
  StationSnapshot period_;
  std::int64_t period_began_ns_ = 0;
  std::uint64_t ticks_before_ = 0;
  std::uint64_t replies_before_ = 0;
  Histogram period_round_trip_;
  Histogram period_step_;
};

/// Returns the same wrench at the handle's origin: tau_H = tau + (R c) x F.
/// @param q_WH  rotation of the tool.   @param p_HT  where `wrench` acts, in the tool's frame [m].
Wrench ShiftToHandle(const Wrench& wrench, const Quat& q_WH, const Vec3& p_HT) noexcept;

}  // namespace palpate
