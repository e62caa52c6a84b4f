#pragma once

#include <array>
#include <string>
#include <vector>

#include "devices/forcedimension/dhd_abi.h"

namespace palpate::test {

/// What the library pretends to have; a sigma.7 that has just been switched on.
struct FakeDhdSetup {
  int arms = 1;
  int serial = 4711;
  int type = dhd::kSigma7;
  std::string name = "sigma.7";
  bool wrist = true;
  bool active_wrist = true;
  bool active_gripper = true;
  bool calibrated = true;
  /// Forces stay off until dhdEnableForce, as a sigma's do; false: they are on once it is open.
  bool forces_wait = true;
};

/// The fake library's other side.  Strict: what a real library would forbid is a violation.
/// One thread, the test's.
class FakeDhd {
 public:
  FakeDhdSetup setup;
  std::array<double, 3> position_m{};  ///< all in the library's frame
  std::array<double, 3> velocity_m_s{};
  std::array<std::array<double, 3>, 3> rotation{};
  unsigned buttons = 0;
  std::array<int, 17> status{};
  int answer = 0;  ///< of what succeeds: zero, DHD_TIMEGUARD or DHD_MOTOR_SATURATED

  // What came of it.
  std::array<double, 3> force_N{};
  std::array<double, 3> torque_Nm{};
  bool open = false;
  bool gravity = false;
  bool emulates_button = false;

  /// As if the library had just been loaded.
  virtual void Reset(const FakeDhdSetup& setup) = 0;
  /// The nth call of that function from now on, 1 the next, fails with this code.
  virtual void Fail(const std::string& function, int nth, int code) = 0;
  virtual bool FailurePending() = 0;
  /// The arm takes its force away, by itself.
  virtual void TakeForce(int cause) = 0;
  /// The user presses the arm's force button.
  virtual void GiveForce() = 0;
  /// Of what was told, as the motors have it.
  virtual double MotorForce() = 0;
  virtual std::vector<std::string> Calls() = 0;
  virtual std::vector<std::string> Violations() = 0;

 protected:
  ~FakeDhd() = default;
};

/// What the library exports beside DHD's own functions.
inline constexpr const char* kFakeDhdFunction = "palpate_fake_dhd";

}  // namespace palpate::test
