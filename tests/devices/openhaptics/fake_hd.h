#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "devices/openhaptics/hd_abi.h"

namespace palpate::test {

/// The arm behind the fake library: a point mass in the grip of a hand, which is a spring and a
/// damper to where the test wants it.  All atomics, so that it can lie in a file that another
/// process sees, too (kFakeArmVariable).
struct FakeArm {
  // What the test sets.
  std::array<std::atomic<double>, 3> hand_mm{};
  std::atomic<std::uint32_t> buttons{0};
  // What came of it.
  std::array<std::atomic<double>, 3> position_mm{};
  std::atomic<double> force_N{0.0};            ///< of the motors just now, its norm
  std::atomic<double> most_force_N{0.0};       ///< so far
  std::atomic<std::int64_t> last_force_ns{0};  ///< steady clock: when it was last more than none
  std::atomic<std::uint64_t> ticks{0};
};

/// Names a file that holds a FakeArm; the library then takes that one and runs in real time.
inline constexpr const char* kFakeArmVariable = "PALPATE_FAKE_HD_ARM";

inline const std::string kAnyFunction;

/// What the library pretends to have.
struct FakeHdSetup {
  bool real_time = false;  ///< a scheduler thread of its own; else the test calls Tick
  std::vector<std::string> names = {"Default Device"};
  bool default_name = true;  ///< hdInitDevice(NULL) opens it
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
  /// Nothing moves the arm but the test: of a constant force on a hand that gives way the limiter
  /// would let nothing through.
  bool held_fast = true;
  hd::Enum refused_capability = 0;
};

/// One frame, as the arm got it.
struct FakeFrame {
  std::uint64_t tick = 0;
  bool force_set = false;
  bool torque_set = false;
  bool motors_on = false;
  std::array<double, 3> force_N{};
  std::array<double, 3> torque_mNm{};
};

/// The fake library's other side.  It is strict: what a real library would forbid, or answer in a
/// way that nobody knows, is a violation.
/// Thread contract: setup, the fields and Tick belong to the test's thread while the scheduler of
/// real time does not run; the methods may be called at any time.
class FakeHd {
 public:
  FakeHdSetup setup;
  FakeArm* arm = nullptr;
  std::array<double, 16> transform_scale{};  ///< added to the transform: an encoder's noise
  std::array<double, 6> temperature{};
  bool docked = false;
  bool unplugged = false;       ///< getters give nothing, each frame ends with HD_COMM_ERROR
  double tick_elapsed_s = 0.0;  ///< of virtual time
  hd::Code endless_error = hd::kSuccess;  ///< what hdGetError gives for ever
  std::array<double, 4> rotation_wxyz{1.0, 0.0, 0.0, 0.0};

  /// As if the library had just been loaded.
  virtual void Reset(const FakeHdSetup& setup) = 0;
  /// Virtual time: so many ticks of the scheduler, in this thread.
  virtual void Tick(int count = 1) = 0;
  /// The nth call of that function (kAnyFunction: of all together) from now on, 1 the next, gives
  /// this error.
  virtual void Fail(const std::string& function, int nth, hd::Code code) = 0;
  /// Real time: the scheduler's thread ends, and nobody is told.
  virtual void Die() = 0;
  virtual void SetCalibration(hd::Enum status) = 0;

  virtual std::vector<std::string> Violations() = 0;
  virtual std::vector<std::string> Calls() = 0;  ///< in order
  virtual std::vector<FakeFrame> Frames() = 0;
  virtual int CallsOf(const std::string& function) = 0;
  /// Styles given to hdUpdateCalibration.
  virtual std::vector<hd::Enum> Calibrations() = 0;
  virtual bool FailurePending() = 0;
  /// Motors just now.  The amplifier's watchdog is part of the model: 20 ms after the last frame
  /// they are off.
  virtual double MotorForce() = 0;
  virtual bool motors_on() = 0;
  virtual bool running() = 0;
  virtual bool opened() = 0;

 protected:
  ~FakeHd() = default;
};

/// What the library exports beside HD's own functions.
inline constexpr const char* kFakeHdFunction = "palpate_fake_hd";

}  // namespace palpate::test
