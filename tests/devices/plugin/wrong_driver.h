#pragma once

#include <atomic>

#include "devices/plugin/palpate_device.h"

namespace palpate::test {

/// What the driver of wrong_driver.cpp does, and what its arm was told.
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
    kSaysNothing,  ///< fails without a word
  };
  std::atomic<Way> way{kRight};
  std::atomic<double> force_N{0.0};  ///< that the motors give
  std::atomic<bool> open{false};
  std::atomic<int> stops{0};
  std::atomic<bool> held{false};  ///< a call hangs
  double position_m[3] = {0.01, 0.0, 0.0};
  palpate_device_info info{};  ///< as open gives it
  bool opens = true;
  bool open_throws = false;
};

inline constexpr const char* kWrongArmFunction = "palpate_wrong_arm";

}  // namespace palpate::test
