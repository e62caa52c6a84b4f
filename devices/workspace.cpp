#include "devices/workspace.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/json/json_file.h"
#include "devices/wrench_limiter.h"

namespace palpate {

Workspace Workspace::Load(const std::string& file) {
  const JsonNode root = JsonNode::Load(file);
  root.AllowOnly({"description", "centre_mm", "device_in_scene", "tool_in_handle", "scale",
                  "clutch", "walls"});
  Workspace workspace;
  if (const auto node = root.Find("centre_mm")) workspace.centre_m = 1e-3 * node->Vector();
  if (const auto node = root.Find("device_in_scene")) {
    node->AllowOnly({"position_mm", "rotation_deg", "quaternion_wxyz"});
    workspace.X_WD = node->ReadPose();
  }
  if (const auto node = root.Find("tool_in_handle")) {
    node->AllowOnly({"rotation_deg", "quaternion_wxyz"});
    workspace.q_HT = node->ReadPose().q;
  }
  if (const auto node = root.Find("scale")) {
    workspace.scale = node->Number(kLeastScale, kMostScale);
  }
  if (const auto node = root.Find("clutch")) {
    node->AllowOnly({"button"});
    workspace.clutch_button = static_cast<int>(node->At("button").Integer(0, 31));
  }
  if (const auto node = root.Find("walls")) {
    node->AllowOnly({"margin_mm", "force_N"});
    if (const auto margin = node->Find("margin_mm")) {
      workspace.wall_margin_m = 1e-3 * margin->Number(1.0, 1000.0);
    }
    if (const auto force = node->Find("force_N"))
      workspace.wall_force_N = force->Number(0.0, 100.0);
  }
  return workspace;
}

Pose Workspace::ToScene(const Pose& X_DH) const noexcept {
  return {X_WD * Vec3(scale * (X_DH.p - centre_m.value_or(Vec3::Zero()))),
          (X_WD.q * X_DH.q * q_HT).normalized()};
}

Pose Workspace::ToDevice(const Pose& X_WT) const noexcept {
  const Quat q_DW = X_WD.q.conjugate();
  return {centre_m.value_or(Vec3::Zero()) + q_DW * (X_WT.p - X_WD.p) / scale,
          (q_DW * X_WT.q * q_HT.conjugate()).normalized()};
}

Twist Workspace::ToScene(const Twist& V_DH) const noexcept {
  return {scale * (X_WD.q * V_DH.v), X_WD.q * V_DH.w};
}

Wrench Workspace::ToScene(const Wrench& at_handle_D) const noexcept {
  return {X_WD.q * at_handle_D.force, scale * (X_WD.q * at_handle_D.torque)};
}

Wrench Workspace::ToDevice(const Wrench& at_handle_W) const noexcept {
  const Quat q_DW = X_WD.q.conjugate();
  return {q_DW * at_handle_W.force, q_DW * at_handle_W.torque / scale};
}

WorkspaceWalls::WorkspaceWalls(const Vec3& centre_m, const Vec3& reach_m, double margin_m,
                               double end_force_N)
    : centre_(centre_m),
      half_(0.5 * reach_m - Vec3::Constant(margin_m)),
      margin_(margin_m),
      end_force_(end_force_N) {
  if (!(half_.minCoeff() > 0.0)) {
    throw Error("workspace: walls.margin_mm of " + std::to_string(1e3 * margin_m) +
                " leaves no space in a device that reaches " +
                std::to_string(1e3 * reach_m.minCoeff()) +
                " mm along one axis; give less than half");
  }
}

Vec3 WorkspaceWalls::Force(const Vec3& p_DH, const Vec3& v_DH) const noexcept {
  Vec3 force = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double from_centre = p_DH[i] - centre_[i];
    const double depth = std::abs(from_centre) - half_[i];
    if (!(depth > 0.0)) continue;
    const double outwards = from_centre > 0.0 ? 1.0 : -1.0;
    const double spring = end_force_ * std::min(1.0, depth / margin_);
    const double damping = std::clamp(1.0 + outwards * v_DH[i] / kFadeSpeed_m_s, 0.0, 2.0);
    force[i] = -outwards * spring * damping;
  }
  return force;
}

WorkspaceDevice::WorkspaceDevice(std::unique_ptr<Device> device, const Workspace& workspace)
    : device_(std::move(device)),
      workspace_(workspace),
      info_(device_->info()),
      tick_s_(1.0 / info_.rate_Hz) {
  const double force = workspace.wall_force_N.value_or(info_.continuous_force_N);
  if (force > 0.0) {
    walls_.emplace(workspace.centre_m.value_or(info_.workspace_centre_m), info_.workspace_m,
                   workspace.wall_margin_m, force);
  }
  const double s = workspace.scale;
  info_.motion_scale *= s;
  info_.workspace_m *= s;
  info_.workspace_centre_m = workspace.ToScene(Pose{info_.workspace_centre_m, Quat::Identity()}).p;
  info_.position_resolution_m *= s;
  info_.max_stiffness_N_m /= s;
  info_.max_torque_Nm *= s;
  info_.continuous_torque_Nm *= s;
}

DeviceSample WorkspaceDevice::Read() noexcept {
  raw_ = device_->Read();
  DeviceSample seen = raw_;
  seen.X_WH = workspace_.ToScene(raw_.X_WH);
  seen.V_WH = workspace_.ToScene(raw_.V_WH);
  bool down = false;
  if (workspace_.clutch_button) {
    const std::uint32_t bit = std::uint32_t{1} << *workspace_.clutch_button;
    down = (raw_.buttons & bit) != 0;
    seen.buttons &= ~bit;  // the clutch button has no other function
  }
  if (down) {
    if (!clutched_) held_ = seen.X_WH.p + shift_;
    shift_ = held_ - seen.X_WH.p;
    seen.X_WH.p = held_;
    seen.V_WH.v = Vec3::Zero();
  } else {
    seen.X_WH.p += shift_;
  }
  clutched_ = down;
  return seen;
}

void WorkspaceDevice::Shape(Wrench& contact, Wrench& led) noexcept {
  gain_ = clutched_ ? std::max(0.0, gain_ - tick_s_ / kClutchOut_s)
                    : std::min(1.0, gain_ + tick_s_ / kClutchIn_s);
  for (Wrench* wrench : {&contact, &led}) {
    wrench->force *= gain_;
    wrench->torque *= gain_;
  }
  Wrench contact_D = workspace_.ToDevice(contact);
  Wrench led_D = workspace_.ToDevice(led);
  device_->Shape(contact_D, led_D);
  if (walls_) contact_D.force += walls_->Force(raw_.X_WH.p, raw_.V_WH.v);
  contact = workspace_.ToScene(contact_D);
  led = workspace_.ToScene(led_D);
}

void WorkspaceDevice::Apply(const LimitedWrench& wrench) noexcept {
  device_->Apply(LimitedWrench(workspace_.ToDevice(wrench.wrench())));
}

void WorkspaceDevice::SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept {
  const Pose unshifted{X_WG.p - shift_, X_WG.q};
  device_->SeeGraphicTool(workspace_.ToDevice(unshifted),
                          workspace_.q_HT * p_HT / workspace_.scale);
}

const char* WorkspaceDevice::activity() const noexcept {
  return clutched_ ? "holds the clutch" : device_->activity();
}

}  // namespace palpate
