#include "client/station/station_core.h"

#include <algorithm>
#include <utility>

#include "common/step_fault.h"

namespace palpate {

Wrench ShiftToHandle(const Wrench& wrench, const Quat& q_WH, const Vec3& p_HT) noexcept {
  return {wrench.force, wrench.torque + (q_WH * p_HT).cross(wrench.force)};
}

StationCore::StationCore(Device& device, double most_force_N)
    : device_(device), limiter_(WrenchLimits::Of(device.info(), most_force_N)) {}

void StationCore::SetSpring(const CouplingSpring& spring) noexcept {
  tool_reference_ = spring.reference;
  local_model_.SetSpring(spring);
  limiter_.SetStiffness(spring.stiffness);
}

void StationCore::LoseSession() noexcept {
  if (!graphic_known_) return;
  graphic_known_ = false;
  device_.LoseGraphicTool();
  local_model_.Forget();
  lead_.Forget();
}

OutgoingPose StationCore::Sense(std::int64_t now_ns, bool sending) noexcept {
  sample_ = device_.Read();
  const bool was_at_fault = std::exchange(device_at_fault_, (sample_.status & kDeviceFault) != 0);
  totals_.device_faults += device_at_fault_ && !was_at_fault;
  totals_.device_fault_ticks += device_at_fault_;
  if (limiter_.enabled()) sample_.status |= kDeviceForcesEnabled;
  OutgoingPose pose{sequence_, now_ns, sample_, sample_.X_WH};
  if (!sending) return pose;
  pose.sequence = ++sequence_;
  ++totals_.sent;
  // A reply that is used unchanged must be for the hand's actual pose.
  if (local_model_.enabled()) pose.X_WH = lead_.Lead(now_ns, sample_.X_WH);
  sent_[sequence_ % kRemembered] = {now_ns, pose.X_WH};
  return pose;
}

void StationCore::Take(const Reply& reply) noexcept {
  // Accepts only a reply to a pose as it was sent, newer than the last reply: anything else is not
  // ours.  So the age of a reply comes from this station's own clock.
  const SentPose& sent = sent_[reply.pose_sequence % kRemembered];
  if (reply.pose_sequence <= newest_.pose_sequence || reply.pose_sequence > sequence_ ||
      sequence_ - reply.pose_sequence >= kRemembered || reply.pose_time_ns != sent.time_ns) {
    ++totals_.strays;
    return;
  }
  newest_ = reply;
  has_reply_ = graphic_known_ = true;
  local_model_.Take(reply, sent.X_WH);
  ++totals_.replies;
  const std::int64_t round_trip = reply.received_ns - reply.pose_time_ns;
  totals_.late += round_trip > kLate_ns;
  totals_.round_trip.Add(round_trip);
  lead_.Hear(1e-9 * static_cast<double>(round_trip));
  period_round_trip_.Add(round_trip);
  const double step_s = reply.step_time_s > 0.0 ? std::min(reply.step_time_s, 1.0) : 0.0;
  const auto step = static_cast<std::int64_t>(1e9 * step_s);
  totals_.server_step.Add(step);
  period_step_.Add(step);
  // The server ramps a session's force in.
  if (reply.faults & kFaultNotStarted) {
    started_ = false;
  } else if (!started_) {
    started_ = true;
    const double inside_m = (reply.X_WG.p - sent.X_WH.p).norm();
    if (inside_m > kInside_m) entered_until_ns_ = reply.received_ns + kEntry_ns;
  }
  totals_.contact_replies += reply.contacts > 0;
  totals_.max_contacts = std::max(totals_.max_contacts, reply.contacts);
  totals_.faults |= reply.faults & ~kFaultNotStarted;  // every session begins with that one
  period_.faults |= reply.faults;
}

void StationCore::Act(std::int64_t now_ns) noexcept {
  limiter_.Enable(forces_wanted_ && !muted_ && !(sample_.status & kDeviceFault));
  LimiterInput in;
  in.X_WH = sample_.X_WH;
  in.V_WH = sample_.V_WH;
  in.motor_temperature = sample_.motor_temperature;
  if (last_act_ns_ > 0) in.dt_s = 1e-9 * static_cast<double>(now_ns - last_act_ns_);
  if (has_reply_) {
    in.silence_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(
                              0, now_ns - newest_.received_ns));  // < 0 if it came in this tick
    in.age_s = 1e-9 * static_cast<double>(now_ns - newest_.pose_time_ns);
    period_.silence_s_max = std::max(period_.silence_s_max, in.silence_s);
  }
  last_act_ns_ = now_ns;
  if (period_began_ns_ == 0) period_began_ns_ = now_ns;
  const LocalContactModel::Evaluation contact = local_model_.At(now_ns, sample_.X_WH);
  totals_.evaluations += contact.evaluated;
  totals_.beyond_region += contact.beyond_region;
  in.entering = now_ns < entered_until_ns_;
  // Effects, like the guide, are not contacts, so the model does not move them to the newest pose.
  // Effects that are not passive are added to the guide's force.
  const auto at_handle = [this](const Wrench& wrench) {
    return ShiftToHandle(wrench, sample_.X_WH.q, tool_reference_);
  };
  in.wanted = at_handle(Sum(contact.wrench, newest_.passive));
  in.led = Sum(guide_.Pull(now_ns, in.dt_s, sample_.X_WH, sample_.V_WH), at_handle(newest_.active));
  device_.Shape(in.wanted, in.led);
  asked_ = in;
  const LimitedWrench limited = limiter_.Limit(in);
  if (graphic_known_) device_.SeeGraphicTool(newest_.X_WG, tool_reference_);
  device_.Apply(limited);

  ++totals_.ticks;
  applied_ = limited.wrench();
  const double force = applied_.force.norm();
  totals_.max_force_N = std::max(totals_.max_force_N, force);
  const double torque = applied_.torque.norm();
  totals_.max_torque_Nm = std::max(totals_.max_torque_Nm, torque);
  period_.peak_force_N = std::max(period_.peak_force_N, force);
  period_.peak_torque_Nm = std::max(period_.peak_torque_Nm, torque);
  // std::max(a, NaN) is a.
  period_.wanted_force_N_max =
      std::max(period_.wanted_force_N_max, (in.wanted.force + in.led.force).norm());
  period_.wanted_torque_Nm_max =
      std::max(period_.wanted_torque_Nm_max, (in.wanted.torque + in.led.torque).norm());
  period_.status |= sample_.status;
}

std::uint64_t StationCore::lost() const noexcept {
  // Counts up to the newest answered pose: later ones may still be in flight.
  return newest_.pose_sequence - answered_before_ - totals_.replies;
}

void StationCore::RestartTotals() noexcept {
  totals_ = StationTotals();
  answered_before_ = newest_.pose_sequence;
  ticks_before_ = 0;
  replies_before_ = 0;
}

StationSnapshot StationCore::TakeSnapshot(std::int64_t now_ns) noexcept {
  StationSnapshot snapshot = std::exchange(period_, {});
  snapshot.time_ns = now_ns;
  const double period_s = 1e-9 * static_cast<double>(now_ns - period_began_ns_);
  if (period_s > 0.0) {
    snapshot.rate_hz = static_cast<double>(totals_.ticks - ticks_before_) / period_s;
  }
  const auto microseconds = [](std::uint64_t ns) { return 1e-3 * static_cast<double>(ns); };
  snapshot.nominal_hz = device_.info().rate_Hz;
  snapshot.device_at_fault = device_at_fault_;
  snapshot.round_trip_us_p50 = microseconds(period_round_trip_.Quantile(0.5));
  snapshot.round_trip_us_p99 = microseconds(period_round_trip_.Quantile(0.99));
  snapshot.server_step_us_p50 = microseconds(period_step_.Quantile(0.5));
  snapshot.replies = totals_.replies - replies_before_;
  snapshot.contacts = newest_.contacts;
  snapshot.force_N = applied_.force.norm();
  snapshot.torque_Nm = applied_.torque.norm();
  snapshot.sent = totals_.sent;
  snapshot.late = totals_.late;
  snapshot.lost = lost();
  snapshot.fades = limiter_.counts().fades;
  snapshot.fading = limiter_.fading();
  snapshot.activity = device_.activity();
  snapshot.ticks = totals_.ticks - ticks_before_;
  snapshot.limiter = limiter_.counts();
  snapshot.energy_J = limiter_.observer().energy_J();
  snapshot.energy_J_min = limiter_.observer().lowest_J();
  snapshot.warmth = limiter_.warmth();

  period_began_ns_ = now_ns;
  ticks_before_ = totals_.ticks;
  replies_before_ = totals_.replies;
  period_round_trip_.Clear();
  period_step_.Clear();
  return snapshot;
}

}  // namespace palpate
