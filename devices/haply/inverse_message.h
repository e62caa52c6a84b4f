#pragma once

#include <cstdint>
#include <string>

#include "common/math/pose.h"

namespace palpate::haply {

// Messages of Haply's Inverse Service, in the JSON format of version 3.x, as documented for 3.5.
// The service's frame has x to the right, y forward and z up; W has x to the right, y up and z
// towards the user: a rotation by -90 degrees about x.  Metres, m/s, newtons.

/// The devices of the service, from its first message.
struct Inventory {
  std::string device_id;
  std::string type;        ///< "inverse3", "inverse3x", "minverse"
  bool centred = false;    ///< its preset puts the origin in the centre of the reach
  std::string grip_array;  ///< "wireless_verse_grip" or "verse_grip"; empty: none
  std::string grip_id;
};
/// @param wanted  id of the device; empty: the first.
/// Throws Error, with the remedy.
Inventory ParseInventory(const std::string& text, const std::string& wanted);

/// The fault of a reply.
enum class Lie { kNone, kNotJson, kNoDevice, kPosition, kVelocity, kOrientation, kGrip };
/// Returns the fault in words, with a remedy.
const char* TextOf(Lie lie) noexcept;

/// A reply, converted to W.
struct Reading {
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
  Quat q = Quat::Identity();
  std::uint32_t buttons = 0;
  bool calibrated = true;  ///< true unless the reply says otherwise
};
/// Fills in the reading if the reply is valid; else leaves it unchanged and returns the fault.
Lie ParseReply(const std::string& text, const Inventory& inventory, Reading& reading);

/// Returns the command that requests a force [N, in W] until the next message.
/// @param first  also identifies this program.
std::string ForceMessage(const Inventory& inventory, const Vec3& force, bool first = false);

}  // namespace palpate::haply
