#include "devices/simulated/simulated_phantom.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error.h"
#include "common/math/rotation.h"
#include "devices/device_factory.h"
#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

/// Velocity is estimated through a first-order low-pass.
constexpr double kVelocityFilter_rad_s = 2.0 * 3.14159265358979323846 * 100.0;

double Quantise(double value, double step) noexcept {
  return step > 0.0 ? std::round(value / step) * step : value;
}

/// Returns momentum p after dry friction with an impulse of at most `limit` and after viscous drag.
/// Friction reduces the momentum to zero at most, and never reverses it.
Vec3 Brake(const Vec3& p, double limit, double drag_factor) noexcept {
  const double size = p.norm();
  if (size <= limit) return Vec3::Zero();
  return p * ((1.0 - limit / size) / (1.0 + drag_factor));
}

Vec3 Saturate(const Vec3& v, double bound) noexcept {
  const double size = v.norm();
  return size > bound ? Vec3(v * (bound / size)) : v;
}

}  // namespace

Wrench SimulatedHand::WrenchOn(const Pose& X_WH, const Twist& V_WH, double t) const noexcept {
  const Pose wanted = script_.At(t);
  const Twist moving = script_.VelocityAt(t);
  return {impedance_.stiffness_N_m * (wanted.p - X_WH.p) +
              impedance_.damping_N_s_m * (moving.v - V_WH.v),
          impedance_.stiffness_Nm_rad * RotationLog(wanted.q * X_WH.q.conjugate()) +
              impedance_.damping_Nm_s * (moving.w - V_WH.w)};
}

SimulatedPhantom::SimulatedPhantom(const PhantomSheet& sheet, std::optional<SimulatedHand> hand,
                                   const Pose& X_WH)
    : info_(sheet.info),
      dynamics_(sheet.dynamics),
      tick_s_(1.0 / sheet.info.rate_Hz),
      substeps_(static_cast<int>(std::ceil(tick_s_ / kSubstep_s - 1e-9))),
      velocity_share_(1.0 - 1.0 / (1.0 + kVelocityFilter_rad_s * tick_s_)),
      hand_(std::move(hand)),
      mass_(dynamics_.mass_kg + (hand_ ? hand_->impedance().mass_kg : 0.0)),
      inertia_(dynamics_.inertia_kg_m2 + (hand_ ? hand_->impedance().inertia_kg_m2 : 0.0)),
      X_WH_(X_WH) {
  if (!(info_.rate_Hz >= 100.0 && info_.rate_Hz <= kMaxRate_Hz)) {
    throw Error("simulated arm: rate_Hz is " + std::to_string(info_.rate_Hz) +
                "; give 100 to 4000");
  }
  encoded_ = Encoded();
}

Pose SimulatedPhantom::Encoded() const noexcept {
  Pose read;
  for (int i = 0; i < 3; ++i) read.p[i] = Quantise(X_WH_.p[i], info_.position_resolution_m);
  // A quaternion's component changes by half the angle.  Rounding it has no singular direction,
  // unlike gimbal angles or a rotation vector.
  const double step = 0.5 * info_.rotation_resolution_rad;
  const Quat& q = X_WH_.q;
  read.q = Quat(Quantise(q.w(), step), Quantise(q.x(), step), Quantise(q.y(), step),
                Quantise(q.z(), step))
               .normalized();
  return read;
}

DeviceSample SimulatedPhantom::Read() noexcept {
  return {encoded_, estimated_V_, 0, kDeviceOk};
}

const char* SimulatedPhantom::activity() const noexcept {
  return hand_ ? hand_->script().LabelAt(time()) : "";
}

double SimulatedPhantom::kinetic_energy_J() const noexcept {
  return 0.5 * mass_ * V_WH_.v.squaredNorm() + 0.5 * inertia_ * V_WH_.w.squaredNorm();
}

Wrench SimulatedPhantom::MotorWrench(const Wrench& commanded) const noexcept {
  if (info_.torque_axes == 0) return {Saturate(commanded.force, info_.max_force_N), Vec3::Zero()};
  const Vec3 roll_axis = X_WH_.q * Vec3::UnitZ();
  const double roll = commanded.torque.dot(roll_axis);
  const Vec3 yaw_pitch = commanded.torque - roll * roll_axis;
  return {Saturate(commanded.force, info_.max_force_N),
          Saturate(yaw_pitch, info_.max_torque_Nm) +
              std::clamp(roll, -dynamics_.max_roll_torque_Nm, dynamics_.max_roll_torque_Nm) *
                  roll_axis};
}

void SimulatedPhantom::Substep(const Wrench& motor, double t, double h) noexcept {
  Wrench on_handle = motor;
  if (hand_) {
    const Wrench hand = hand_->WrenchOn(X_WH_, V_WH_, t);
    on_handle.force += hand.force;
    on_handle.torque += hand.torque;
  }
  V_WH_.v = Brake(mass_ * V_WH_.v + h * on_handle.force, h * dynamics_.coulomb_force_N,
                  h * dynamics_.viscous_N_s_m / mass_) /
            mass_;
  // A ball's inertia: no gyroscopic torque.  No tensor of the real gimbal is published.
  V_WH_.w = Brake(inertia_ * V_WH_.w + h * on_handle.torque, h * dynamics_.coulomb_torque_Nm,
                  h * dynamics_.viscous_Nm_s / inertia_) /
            inertia_;
  X_WH_.p += h * V_WH_.v;
  X_WH_.q = (RotationExp(h * V_WH_.w) * X_WH_.q).normalized();
  // The workspace ends at perfectly inelastic stops.
  for (int i = 0; i < 3; ++i) {
    const double half = 0.5 * info_.workspace_m[i];
    if (std::abs(X_WH_.p[i]) <= half) continue;
    X_WH_.p[i] = std::copysign(half, X_WH_.p[i]);
    if (V_WH_.v[i] * X_WH_.p[i] > 0.0) V_WH_.v[i] = 0.0;
  }
}

void SimulatedPhantom::Apply(const LimitedWrench& wrench) noexcept {
  Pass(wrench.wrench());
}

void SimulatedPhantom::Pass(const Wrench& commanded) noexcept {
  const Wrench motor = MotorWrench(commanded);
  const double h = tick_s_ / substeps_;
  for (int i = 0; i < substeps_; ++i) Substep(motor, time() + i * h, h);
  ++ticks_;

  const Pose now = Encoded();
  const Vec3 v = (now.p - encoded_.p) / tick_s_;
  const Vec3 w = RotationLog(now.q * encoded_.q.conjugate()) / tick_s_;
  estimated_V_.v += velocity_share_ * (v - estimated_V_.v);
  estimated_V_.w += velocity_share_ * (w - estimated_V_.w);
  encoded_ = now;
}

DeviceKind SimulatedKind() {
  DeviceKind kind{
      .name = "simulated",
      .what = "a simulated arm and a hand that follows a script",
      .needs_script = true,
      .max_rate_Hz = SimulatedPhantom::kMaxRate_Hz,
      .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
        PhantomSheet sheet = PhantomSheetOf(options.model);
        sheet.info.rate_Hz = options.rate_Hz;
        SimulatedHand hand(ScriptPlayer(*options.script, options.loop), HandImpedance{});
        return std::make_unique<SimulatedPhantom>(sheet, std::move(hand), options.script->At(0.0));
      }};
  for (const PhantomSheet& sheet : PhantomSheets()) kind.models.push_back(sheet.name);
  return kind;
}

}  // namespace palpate
