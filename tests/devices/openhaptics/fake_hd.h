#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "devices/openhaptics/hd_abi.h"

namespace palpate::test {

/// The arm behind the fake library: a point mass held by a hand, which is a spring and a damper to
/// where the test wants it.  All atomics, so that it can lie in a file that another process maps
/// (kFakeArmVariable).
struct FakeArm {
  // What the test sets.
  std::array<std::atomic<double>, 3> hand_mm{};
  std::atomic<std::uint32_t> buttons{0};
  // What the arm does.
  std::array<std::atomic<double>, 3> position_mm{};
  std::atomic<double> force_N{0.0};            ///< norm of the motors' force now
  std::atomic<double> most_force_N{0.0};       ///< the greatest so far
  std::atomic<std::int64_t> last_force_ns{0};  ///< steady clock: when the force was last not zero
  std::atomic<std::uint64_t> ticks{0};
};

/// Names a file with a FakeArm, which the library then uses, in real time.
inline constexpr const char* kFakeArmVariable = "PALPATE_FAKE_HD_ARM";

inline const std::string kAnyFunction;

/// What the library pretends to have.
struct FakeHdSetup {
  bool real_time = false;  ///< has a scheduler thread; else the test calls Tick
  std::vector<std::string> names = {"Default Device"};
  bool default_name = true;  ///< whether hdInitDevice(NULL) succeeds
  hd::Code init_error = hd::kSuccess;
  int input_dof = 6;
  int output_dof = 6;
  double max_force_N = 8.5;
  double continuous_force_N = 1.4;
  double max_torque_mNm = 188.0;
  double continuous_torque_mNm = 48.0;
  int most_rate_Hz = 4000;
  hd::Enum styles = hd::kAuto;
  hd::Enum calibration = hd::kCalibrationOk;
  bool has_temperature = true;
  bool has_inkwell = true;
  /// Only the test moves the arm: under a constant force a hand that gives way would absorb
  /// nothing, and the limiter would pass nothing.
  bool held_fast = true;
  hd::Enum refused_capability = 0;
};

/// One frame as the arm got it.
struct FakeFrame {
  std::uint64_t tick = 0;
  bool force_set = false;
  bool torque_set = false;
  bool motors_on = false;
  std::array<double, 3> force_N{};
  std::array<double, 3> torque_mNm{};
};

/// The test's side of the fake library.  Whatever a real library would forbid, or answer in an
/// undocumented way, is a violation.
/// Thread contract: setup, the fields and Tick belong to the test's thread while the real-time
/// scheduler does not run; the methods may be called at any time.
class FakeHd {
 public:
  FakeHdSetup setup;
  FakeArm* arm = nullptr;
  std::array<double, 16> transform_scale{};  ///< added to the transform: an encoder's noise
  std::array<double, 6> temperature{};
  bool docked = false;
  bool unplugged = false;       ///< getters return nothing, and each frame ends with HD_COMM_ERROR
  double tick_elapsed_s = 0.0;  ///< of virtual time
  hd::Code endless_error = hd::kSuccess;  ///< what hdGetError always returns
  std::array<double, 4> rotation_wxyz{1.0, 0.0, 0.0, 0.0};

  /// Puts the library into the state after loading.
  virtual void Reset(const FakeHdSetup& setup) = 0;
  /// In virtual time: runs `count` ticks of the scheduler in this thread.
  virtual void Tick(int count = 1) = 0;
  /// Makes the nth call of `function` (kAnyFunction: of all functions) from now on report `code`; 1
  /// is the next call.
  virtual void Fail(const std::string& function, int nth, hd::Code code) = 0;
  /// In real time: ends the scheduler's thread without telling anybody.
  virtual void Die() = 0;
  virtual void SetCalibration(hd::Enum status) = 0;

  virtual std::vector<std::string> Violations() = 0;
  virtual std::vector<std::string> Calls() = 0;  ///< in order
  virtual std::vector<FakeFrame> Frames() = 0;
  virtual int CallsOf(const std::string& function) = 0;
  /// Styles passed to hdUpdateCalibration.
  virtual std::vector<hd::Enum> Calibrations() = 0;
  virtual bool FailurePending() = 0;
  /// Norm of the motors' force now [N].  Models the amplifier's watchdog: 20 ms after the last
  /// frame the motors are off.
  virtual double MotorForce() = 0;
  virtual bool motors_on() = 0;
  virtual bool running() = 0;
  virtual bool opened() = 0;

 protected:
  ~FakeHd() = default;
};

/// The function that the library exports beside HD's own.
inline constexpr const char* kFakeHdFunction = "palpate_fake_hd";

}  // namespace palpate::test
