// A driver for tests that does everything a driver should not do.
#include "tests/devices/plugin/wrong_driver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include <fcntl.h>
#include <unistd.h>

using palpate::test::WrongArm;

struct palpate_device {
  WrongArm arm;
  std::uint64_t number = 0;
  double last_N[3] = {};
};

namespace {

palpate_device the_device;

// For a program, which cannot reach WrongArm: the file in which each call is noted, and whether the
// last write had a force.
int the_calls = -1;
bool pressed = false;

void Note(const std::string& call) {
  if (the_calls >= 0) (void)!write(the_calls, (call + "\n").data(), call.size() + 1);
}

/// Crashes in the function that the name asks for.
std::string crashes_in;
void CrashIfAskedTo(const char* function) {
  if (crashes_in == function) *static_cast<volatile int*>(nullptr) = 1;
}

/// Hangs for as long as the test wants it to.
void Hang(WrongArm::Way way) {
  the_device.arm.held = true;
  while (the_device.arm.way == way) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  the_device.arm.held = false;
}

}  // namespace

extern "C" WrongArm* palpate_wrong_arm() {
  return &the_device.arm;
}

#ifndef WRONG_ABI
#define WRONG_ABI PALPATE_DEVICE_ABI
#endif
std::uint32_t palpate_device_abi() {
  return WRONG_ABI;
}

palpate_device* palpate_device_open(const char* name, double, palpate_device_info* info) {
  WrongArm& arm = the_device.arm;
  if (arm.open_throws) throw std::runtime_error("no");
  if (std::strcmp(name, "hangs") == 0) arm.hangs_at = 1000;  // a station cannot reach WrongArm
  if (std::string(name).starts_with("crashes ")) crashes_in = name + std::strlen("crashes ");
  CrashIfAskedTo("open");
  if (std::strcmp(name, "slow") == 0) arm.way = WrongArm::kReadIsSlow;
  if (std::strcmp(name, "exchanges") == 0) arm.exchanges_axes = true;
  if (std::strcmp(name, "hot") == 0) arm.motor_temperature = 1.2;
  if (std::string(name).starts_with("presses ")) {
    arm.presses = true;
    the_calls = open(name + std::strlen("presses "), O_WRONLY | O_CREAT | O_APPEND, 0600);
    Note("open");
  }
  *info = arm.info;
  arm.open = arm.opens;
  return arm.opens ? &the_device : nullptr;
}

int palpate_device_read(palpate_device* device, palpate_device_reading* reading) {
  WrongArm& arm = device->arm;
  std::memcpy(reading->position_m, arm.position_m, sizeof arm.position_m);
  double* const wxyz = reading->orientation_wxyz;
  if (arm.way != WrongArm::kStuck) ++device->number;
  reading->number = device->number;
  // Down onto the cube within a second or so, then into it.
  if (arm.presses) {
    reading->position_m[0] = 0.0;
    reading->position_m[1] = std::max(0.028, 0.036 - 1e-5 * static_cast<double>(device->number));
  }
  if (arm.exchanges_axes) {
    for (int i = 0; i < 3; ++i) reading->position_m[i] = 2e-3 * device->last_N[i < 2 ? 1 - i : 2];
  }
  if (arm.hangs_at != 0 && device->number == arm.hangs_at) arm.way = WrongArm::kReadHangs;
  if (device->number == 500) CrashIfAskedTo("read");
  const WrongArm::Way way = arm.way;
  reading->buttons = 1;
  reading->motor_temperature = arm.motor_temperature;
  switch (way) {
    case WrongArm::kNotFinite:
      reading->position_m[1] = std::nan("");
      break;
    case WrongArm::kFarAway:
      reading->position_m[1] = 10.0;
      break;
    case WrongArm::kNoRotation:
      wxyz[0] = std::nan("");
      break;
    case WrongArm::kLongRotation:
      wxyz[0] = 2.0;
      break;
    case WrongArm::kHardlyLongRotation:
      wxyz[0] = 1.0001;
      break;
    case WrongArm::kJumps:
      if (device->number % 2 == 0) reading->position_m[2] += 0.06;
      break;
    case WrongArm::kReadFails:
    case WrongArm::kSaysNothing:
      return 7;
    case WrongArm::kReadIsSlow:
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      break;
    case WrongArm::kReadThrows:
      throw std::runtime_error("no");
    case WrongArm::kReadHangs:
      Hang(way);
      break;
    default:
      break;
  }
  return 0;
}

int palpate_device_write(palpate_device* device, const double force_N[3], const double[3]) {
  WrongArm& arm = device->arm;
  if (device->number == 500) CrashIfAskedTo("write");
  const WrongArm::Way way = arm.way;
  if (way == WrongArm::kWriteThrows) throw std::runtime_error("no");
  if (way == WrongArm::kWriteHangs) return Hang(way), 0;
  if (way == WrongArm::kWriteFails || way == WrongArm::kStopFails) return 8;
  std::copy_n(force_N, 3, device->last_N);
  arm.force_N = std::hypot(force_N[0], force_N[1], force_N[2]);
  if (pressed != (arm.force_N > 0.0)) Note((pressed = arm.force_N > 0.0) ? "force" : "no force");
  return 0;
}

#ifndef WITHOUT_STOP
int palpate_device_stop(palpate_device* device) {
  ++device->arm.stops;
  Note("stop");
  CrashIfAskedTo("stop");
  if (device->arm.way == WrongArm::kStopFails) return 9;
  device->arm.force_N = 0.0;
  return 0;
}
#endif

void palpate_device_close(palpate_device* device) {
  device->arm.open = false;
  Note("close");
  CrashIfAskedTo("close");
}

const char* palpate_device_last_error(palpate_device* device) {
  if (the_device.arm.way == WrongArm::kSaysNothing) return nullptr;
  return device ? "the cable is out: plug it in" : "no arm is plugged in";
}
