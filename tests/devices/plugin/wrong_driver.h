#pragma once

#include <atomic>

#include "devices/plugin/palpate_device.h"

namespace palpate::test {

/// What the driver of wrong_driver.cpp is to do, and what its arm was told.
struct WrongArm {
  enum Way {
    kRight,
    kNotFinite,
    kFarAway,
    kNoRotation,
    kLongRotation,
    kHardlyLongRotation,
    kReadFails,
    kReadThrows,
    kReadHangs,
    kWriteFails,
    kWriteThrows,
    kWriteHangs,
    kStopFails,  ///< and so does write
    kStuck,
    kJumps,
    kSaysNothing,  ///< fails without an error text
    kReadIsSlow,   ///< takes 5 ms
  };
  std::atomic<Way> way{kRight};
  std::atomic<double> force_N{0.0};  ///< that the motors render
  std::atomic<bool> open{false};
  std::atomic<int> stops{0};
  std::atomic<bool> held{false};  ///< a call is hanging
  double position_m[3] = {0.01, 0.0, 0.0};
  palpate_device_info info{.model = "lever",  ///< as `open` returns it
                           .max_force_N = 5.0,
                           .continuous_force_N = 2.0,
                           .max_torque_Nm = 0.1,
                           .continuous_torque_Nm = 0.05,
                           .workspace_m = {0.3, 0.3, 0.3},
                           .workspace_centre_m = {},
                           .position_resolution_m = 1e-5,
                           .rotation_resolution_rad = 1e-3,
                           .thermal_time_s = 60.0};
  std::uint64_t hangs_at = 0;  ///< number of the reading; 0: never
  double motor_temperature = 0.0;
  bool exchanges_axes = false;  ///< gives way by 2 mm/N, along y where it is pushed along x
  bool presses = false;         ///< moves into the cube
  bool opens = true;
  bool open_throws = false;
};

inline constexpr const char* kWrongArmFunction = "palpate_wrong_arm";

}  // namespace palpate::test
