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
  DeviceSample sample;  ///< as the device was read
  /// To be sent in its place: with the local contact model on, the pose that the hand is likely to
  /// have when the reply comes (PoseLead).
  Pose X_WH;
};

/// What a station has seen so far.
struct StationTotals {
  std::uint64_t ticks = 0;
  std::uint64_t sent = 0;
  std::uint64_t replies = 0;
  std::uint64_t strays =
      0;  ///< replies to nothing that was asked, and replies out of order: not used
  std::uint64_t late = 0;  ///< replies that took more than 1 ms
  std::uint64_t contact_replies = 0;
  std::uint32_t max_contacts = 0;
  std::uint32_t faults = 0;  ///< every bit seen
  double max_force_N = 0.0;  ///< given to the device
  double max_torque_Nm = 0.0;
  std::uint64_t evaluations = 0;    ///< ticks whose wrench came from the local contact model's rows
  std::uint64_t beyond_region = 0;  ///< of these, ticks for which the rows were too far or too old
  Histogram round_trip;             ///< pose out to wrench in [ns]
  Histogram server_step;            ///< [ns]
};

/// What a display shows of a moment; figures "of the period" cover the time since the last one.
struct StationSnapshot {
  std::int64_t time_ns = 0;
  double rate_hz = 0.0;            ///< ticks, of the period
  double round_trip_us_p50 = 0.0;  ///< of the period; zero where no reply came
  double round_trip_us_p99 = 0.0;
  double server_step_us_p50 = 0.0;
  std::uint64_t replies = 0;   ///< of the period
  std::uint32_t contacts = 0;  ///< of the latest reply
  std::uint32_t faults = 0;    ///< every bit of the period
  double force_N = 0.0;        ///< given to the device at the end of the period
  double torque_Nm = 0.0;
  double peak_force_N = 0.0;  ///< of the period
  std::uint64_t sent = 0;     ///< from here on: in all
  std::uint64_t late = 0;
  std::uint64_t lost = 0;  ///< poses without an answer, but for those still on their way
  std::uint64_t fades = 0;
  bool fading = false;
  const char* activity = "";  ///< Device::activity
  // What StationStatistics says besides.
  std::uint64_t ticks = 0;            ///< of the period
  double silence_s_max = 0.0;         ///< of the period; counts once there was a reply
  double wanted_force_N_max = 0.0;    ///< of the period: contact and guide, before the limiter
  double wanted_torque_Nm_max = 0.0;  ///< likewise
  double peak_torque_Nm = 0.0;        ///< of the period
  std::uint32_t status = 0;           ///< of the device: every bit of the period
  LimiterCounts limiter;              ///< in all
  double energy_J = 0.0;              ///< WrenchLimiter::observer, in all
  double energy_J_min = 0.0;
  double warmth = 0.0;  ///< WrenchLimiter::warmth
};

/// The station's servo loop without its clock and its transport: reads the device, gives the pose
/// to send, takes the replies, and drives the device through the limiter.  Time comes in as an
/// argument, so a dying server is a unit test.
/// Thread contract: one thread.
/// Real-time: no method allocates, locks, logs or reads a clock.
class StationCore {
 public:
  static constexpr std::int64_t kLate_ns = 1'000'000;
  /// Poses that a reply may answer: those of the last quarter of a second.
  static constexpr std::size_t kRemembered = 256;

  /// Within this time the server's own ramp is over.
  static constexpr std::int64_t kEntry_ns = 300'000'000;
  /// Further from the hand than this, the graphic tool began outside of an object that the hand is
  /// in.
  static constexpr double kInside_m = 1e-5;

  /// The device must outlive the core.  Throws Error where the device has no limits.
  /// @param most_force_N  as WrenchLimits::Of.
  explicit StationCore(Device& device,
                       double most_force_N = std::numeric_limits<double>::infinity());
  Device& device() noexcept { return device_; }

  void EnableForces(bool on) noexcept { forces_wanted_ = on; }
  /// While muted there are no forces, whoever wants them.
  void Mute(bool on) noexcept { muted_ = on; }
  /// The session's spring: where its wrench acts, what the local contact model goes by, and what a
  /// contact's force must have stored (EnergyStage).
  void SetSpring(const CouplingSpring& spring) noexcept;
  /// Replies' rows are held against the newest pose (the default), or their wrench is taken as it
  /// comes, late.
  void EnableLocalModel(bool on) noexcept { local_model_.Enable(on); }

  /// Lets guides lead the hand, within these limits.  Never called: none does.
  void AcceptGuide(const GuideLimits& limits) noexcept { guide_ = Guide(limits); }
  void Take(std::int64_t now_ns, const GuideAim& aim) noexcept { guide_.Take(now_ns, aim); }
  const Guide& guide() const noexcept { return guide_; }

  /// Nobody answers any more: what was known of the graphic tool is over.  Before Sense.
  void LoseSession() noexcept;
  /// First half of a tick: reads the device.  Where `sending`, the pose gets the next number; where
  /// not, there is no session.
  OutgoingPose Sense(std::int64_t now_ns, bool sending) noexcept;
  /// Takes one of the replies that came since the last tick, oldest first.
  void Take(const Reply& reply) noexcept;
  /// Second half: drives the device by what the newest reply says of the newest pose.
  void Act(std::int64_t now_ns) noexcept;

  /// Counts from here on: what came before, a warm-up say, is forgotten.
  void RestartTotals() noexcept;
  StationSnapshot TakeSnapshot(std::int64_t now_ns) noexcept;
  const StationTotals& totals() const noexcept { return totals_; }
  const WrenchLimiter& limiter() const noexcept { return limiter_; }
  /// What the limiter was last asked for.
  const LimiterInput& asked() const noexcept { return asked_; }
  std::uint64_t lost() const noexcept;
  /// True unless the device was last told to render nothing at all.
  bool renders_force() const noexcept {
    return !applied_.force.isZero(0.0) || !applied_.torque.isZero(0.0);
  }
  /// The newest reply that was used; its sequence is 0 before the first.
  const Reply& newest() const noexcept { return newest_; }
  /// Of the newest pose that was sent.
  std::uint64_t sequence() const noexcept { return sequence_; }
  /// What the limiter last let through: at the handle, in W.
  const Wrench& applied() const noexcept { return applied_; }
  /// When the pose of the newest reply was sampled; 0 before the first.
  std::int64_t newest_reply_ns() const noexcept { return newest_.pose_time_ns; }

 private:
  Device& device_;
  WrenchLimiter limiter_;
  Guide guide_;
  bool forces_wanted_ = false;
  bool muted_ = false;
  bool started_ = false;  // the server's force, by the newest reply
  std::int64_t entered_until_ns_ = 0;
  Vec3 tool_reference_ = Vec3::Zero();
  LocalContactModel local_model_;
  PoseLead lead_;
  LimiterInput asked_;
  DeviceSample sample_;
  Reply newest_;
  bool has_reply_ = false;
  bool graphic_known_ = false;  // in this session
  std::uint64_t sequence_ = 0;
  struct SentPose {
    std::int64_t time_ns = 0;
    Pose X_WH;  // as it was sent
  };
  std::array<SentPose, kRemembered> sent_;  // up to sequence_, by their number
  std::int64_t last_act_ns_ = 0;
  Wrench applied_;
  StationTotals totals_;
  std::uint64_t answered_before_ = 0;  // poses up to here are not of these totals

  // Of the period.
  StationSnapshot period_;
  std::int64_t period_began_ns_ = 0;
  std::uint64_t ticks_before_ = 0;
  std::uint64_t replies_before_ = 0;
  Histogram period_round_trip_;
  Histogram period_step_;
};

/// The same wrench at the handle's origin: tau_H = tau + (R c) x F.
/// @param q_WH  rotation of the tool.   @param p_HT  where `wrench` acts, in the tool's frame [m].
Wrench ShiftToHandle(const Wrench& wrench, const Quat& q_WH, const Vec3& p_HT) noexcept;

}  // namespace palpate
