#pragma once

#include <array>
#include <string>
#include <vector>

#include "devices/forcedimension/dhd_abi.h"

namespace palpate::test {

/// What the library pretends to have: a sigma.7 that has just been switched on.
struct FakeDhdSetup {
  int arms = 1;
  int serial = 4711;
  int type = dhd::kSigma7;
  std::string name = "sigma.7";
  bool wrist = true;
  bool active_wrist = true;
  bool active_gripper = true;
  bool calibrated = true;
  /// Whether forces stay off until dhdEnableForce, as a sigma's do; else opening turns them on.
  bool forces_wait = true;
};

/// The test's side of the fake library.  Whatever a real library would forbid is a violation. For
/// one thread, the test's.
class FakeDhd {
 public:
  FakeDhdSetup setup;
  std::array<double, 3> position_m{};  ///< all in the library's frame
  std::array<double, 3> velocity_m_s{};
  std::array<std::array<double, 3>, 3> rotation{};
  unsigned buttons = 0;
  std::array<int, 17> status{};
  int answer = 0;  ///< what calls that succeed return: zero, DHD_TIMEGUARD or DHD_MOTOR_SATURATED

  // What the driver did.
  std::array<double, 3> force_N{};
  std::array<double, 3> torque_Nm{};
  bool open = false;
  bool gravity = false;
  bool emulates_button = false;

  /// As if the library had just been loaded.
  virtual void Reset(const FakeDhdSetup& setup) = 0;
  /// Makes the nth call of `function` from now on fail with `code`; 1 is the next call.
  virtual void Fail(const std::string& function, int nth, int code) = 0;
  virtual bool FailurePending() = 0;
  /// The arm switches its force off by itself.
  virtual void TakeForce(int cause) = 0;
  /// The user presses the arm's force button.
  virtual void GiveForce() = 0;
  /// Norm of the force that the motors render [N].
  virtual double MotorForce() = 0;
  virtual std::vector<std::string> Calls() = 0;
  virtual std::vector<std::string> Violations() = 0;

 protected:
  ~FakeDhd() = default;
};

/// The function that the library exports beside DHD's own.
inline constexpr const char* kFakeDhdFunction = "palpate_fake_dhd";

}  // namespace palpate::test
