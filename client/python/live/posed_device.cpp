#include "client/python/live/posed_device.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "common/realtime/steady_clock.h"
#include "devices/blind_hand.h"
#include "devices/wrench_limiter.h"

namespace palpate {

PosedDevice::PosedDevice(const Pose& start, double max_force_N, double max_torque_Nm) {
  info_.model = "program (poses from Python)";
  info_.max_force_N = info_.continuous_force_N = max_force_N;
  info_.max_torque_Nm = info_.continuous_torque_Nm = max_torque_Nm;
  info_.workspace_m = Vec3::Constant(20.0);
  info_.simulated = true;
  now_.X_WH = X_W0_ = start;
  felt_.Write(now_);
}

std::uint64_t PosedDevice::Go(const Pose& X_WT, double seconds) {
  const std::lock_guard lock(callers_);
  orders_.Write({++moves_, X_WT, seconds});
  return moves_;
}

Felt PosedDevice::felt() {
  const std::lock_guard lock(callers_);
  felt_.Read(newest_);
  return newest_;
}

void PosedDevice::Lead(const HeldWrench& held) {
  const std::lock_guard lock(callers_);
  leads_.Write(held);
}

void PosedDevice::Begin(const Move& move) noexcept {
  move_ = move;
  X_W0_ = now_.X_WH;
  const Vec3 way = move.X_WT.p - X_W0_.p;
  phi_ = RotationLog((move.X_WT.q * X_W0_.q.conjugate()).normalized());
  const double least_s =
      std::max(way.norm() / BlindHand::kMaxSpeed_m_s, phi_.norm() / BlindHand::kMaxTurn_rad_s);
  // At most an hour, so that the number of ticks fits into an int.
  const double seconds = std::clamp(std::max(move.seconds, least_s), kTick_s, 3600.0);
  ticks_ = static_cast<int>(std::ceil(seconds / kTick_s - 1e-6));
  tick_ = 0;
  v_ = way / (ticks_ * kTick_s);
}

DeviceSample PosedDevice::Read() noexcept {
  if (Move move; orders_.Read(move)) Begin(move);
  const bool under_way = tick_ < ticks_;
  if (under_way) {
    ++tick_;
    const double share = static_cast<double>(tick_) / ticks_;
    now_.X_WH.p = X_W0_.p + share * (move_.X_WT.p - X_W0_.p);
    now_.X_WH.q = (RotationExp(share * phi_) * X_W0_.q).normalized();
    if (tick_ == ticks_) {
      now_.X_WH = move_.X_WT;  // exactly
      now_.move = move_.number;
      now_.arrived_ns = SteadyNanoseconds();
    }
  }
  now_.V_WH = under_way ? Twist{v_, phi_ / (ticks_ * kTick_s)} : Twist{};
  return {now_.X_WH, now_.V_WH, 0, kDeviceForcesIgnored};
}

void PosedDevice::Shape(Wrench& contact, Wrench& led) noexcept {
  if (leads_.Read(held_)) held_ticks_ = std::max<std::uint64_t>(50, 4 * held_.every);
  if (held_ticks_ > 0) {
    --held_ticks_;
    const Wrench given = held_.At(now_.X_WH);
    led = {led.force + given.force, led.torque + given.torque};
  }
  now_.wanted = {contact.force + led.force, contact.torque + led.torque};
}

void PosedDevice::Apply(const LimitedWrench& wrench) noexcept {
  now_.applied = wrench.wrench();
  felt_.Write(now_);
}

void PosedDevice::SeeGraphicTool(const Pose& X_WG, const Vec3&) noexcept {
  now_.X_WG = X_WG;
  now_.sees_tool = true;
}

}  // namespace palpate
