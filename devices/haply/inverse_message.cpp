#include "devices/haply/inverse_message.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "common/error.h"

namespace palpate::haply {
namespace {

using Json = nlohmann::json;

/// Limits beyond the reach of these devices and the speed of a hand.
constexpr double kFarthest_m = 1.0;
constexpr double kFastest_m_s = 20.0;
/// Tolerance of a quaternion's norm: floats are sent with few digits.
constexpr double kNormNoise = 0.05;

const Json* Member(const Json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

bool Number(const Json& object, const char* name, double& value) {
  const Json* member = Member(object, name);
  if (!member || !member->is_number()) return false;
  value = member->get<double>();
  return std::isfinite(value);
}

bool Vector(const Json* object, double most, Vec3& value_W) {
  double x = 0.0, y = 0.0, z = 0.0;
  if (!object || !Number(*object, "x", x) || !Number(*object, "y", y) || !Number(*object, "z", z)) {
    return false;
  }
  value_W = Vec3(x, z, -y);
  return std::abs(x) < most && std::abs(y) < most && std::abs(z) < most;
}

bool Rotation(const Json* object, Quat& q_W) {
  double w = 0.0, x = 0.0, y = 0.0, z = 0.0;
  if (!object || !Number(*object, "w", w) || !Number(*object, "x", x) || !Number(*object, "y", y) ||
      !Number(*object, "z", z)) {
    return false;
  }
  const Quat q(w, x, z, -y);
  if (!(std::abs(q.norm() - 1.0) < kNormNoise)) return false;
  q_W = q.normalized();
  return true;
}

const Json* DeviceOf(const Json& message, const std::string& array, const std::string& id) {
  const Json* devices = Member(message, array.c_str());
  if (!devices || !devices->is_array()) return nullptr;
  for (const Json& device : *devices) {
    const Json* its = Member(device, "device_id");
    if (its && its->is_string() && (id.empty() || *its == id)) return &device;
  }
  return nullptr;
}

bool Pressed(const Json* button) {
  return button && button->is_boolean() && button->get<bool>();
}

std::uint32_t ButtonsOf(const Json& state) {
  std::uint32_t buttons = Pressed(Member(state, "button")) ? 1u : 0u;  // the wired grip has
                                                                       // only one
  if (const Json* several = Member(state, "buttons")) {
    std::uint32_t bit = 1;
    for (const char* name : {"a", "b", "c"}) {
      if (Pressed(Member(*several, name))) buttons |= bit;
      bit <<= 1;
    }
  }
  return buttons;
}

}  // namespace

Inventory ParseInventory(const std::string& text, const std::string& wanted) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) {
    throw Error(
        "haply: the answer is not from an Inverse Service of version 3.1 or newer; check whether "
        "another program uses that port, or update the service with the Haply Hub");
  }
  Inventory inventory;
  const Json* device = DeviceOf(message, "inverse3", wanted);
  if (!device) {
    throw Error("haply: the Inverse Service has no device" +
                (wanted.empty() ? std::string() : " '" + wanted + "'") +
                "; plug it in, switch it on, and check that the Haply Hub shows it; give "
                "--device-name the id shown there");
  }
  inventory.device_id = device->at("device_id").get<std::string>();
  inventory.type = "inverse3";
  if (const Json* config = Member(*device, "config")) {
    const Json* type = Member(*config, "type");
    if (type && type->is_string()) inventory.type = type->get<std::string>();
    const Json* preset = Member(*config, "preset");
    inventory.centred = preset && *preset == "arm_front_centered";
  }
  for (const char* array : {"wireless_verse_grip", "verse_grip"}) {
    const Json* grip = DeviceOf(message, array, "");
    if (!grip) continue;
    inventory.grip_array = array;
    inventory.grip_id = grip->at("device_id").get<std::string>();
    break;
  }
  return inventory;
}

const char* TextOf(Lie lie) noexcept {
  switch (lie) {
    case Lie::kNone:
      return "";
    case Lie::kNotJson:
      return "the Inverse Service sends invalid JSON: restart it, and update it";
    case Lie::kNoDevice:
      return "the Inverse Service has lost the device: check its USB cable and power";
    case Lie::kPosition:
      return "the Inverse Service sends an invalid position: calibrate the device again in the "
             "Haply Hub, and update the service";
    case Lie::kVelocity:
      return "the Inverse Service sends an invalid velocity: update the service";
    case Lie::kOrientation:
      return "the VerseGrip sends an invalid orientation: calibrate it in the Haply Hub";
    case Lie::kGrip:
      return "the VerseGrip has gone: charge it, switch it on, and see that the Haply Hub shows it";
  }
  return "";
}

Lie ParseReply(const std::string& text, const Inventory& inventory, Reading& reading) {
  const Json message = Json::parse(text, nullptr, false);
  if (message.is_discarded()) return Lie::kNotJson;
  const Json* device = DeviceOf(message, "inverse3", inventory.device_id);
  const Json* state = device ? Member(*device, "state") : nullptr;
  if (!state) return Lie::kNoDevice;
  Reading read;
  if (!Vector(Member(*state, "cursor_position"), kFarthest_m, read.p)) return Lie::kPosition;
  if (!Vector(Member(*state, "cursor_velocity"), kFastest_m_s, read.v)) return Lie::kVelocity;
  if (const Json* status = Member(*device, "status")) {
    const Json* calibrated = Member(*status, "calibrated");
    read.calibrated = !calibrated || Pressed(calibrated);
  }
  if (!inventory.grip_array.empty()) {
    const Json* grip = DeviceOf(message, inventory.grip_array, inventory.grip_id);
    const Json* grip_state = grip ? Member(*grip, "state") : nullptr;
    if (!grip_state) return Lie::kGrip;
    if (!Rotation(Member(*grip_state, "orientation"), read.q)) return Lie::kOrientation;
    read.buttons = ButtonsOf(*grip_state);
  }
  reading = read;
  return Lie::kNone;
}

std::string ForceMessage(const Inventory& inventory, const Vec3& force, bool first) {
  Json device;
  device["device_id"] = inventory.device_id;
  device["commands"]["set_cursor_force"]["vector"] = {
      {"x", force.x()}, {"y", -force.z()}, {"z", force.y()}};
  Json message;
  message["inverse3"] = Json::array({device});
  if (first) message["session"]["configure"]["profile"]["name"] = "palpate";
  return message.dump();
}

}  // namespace palpate::haply
