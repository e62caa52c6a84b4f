#pragma once

#include <cstdint>

#include <pybind11/pybind11.h>

#include "common/realtime/steady_clock.h"

namespace palpate {

/// Lets Ctrl-C end a long call that runs without Python's lock.  Call it often: it looks for
/// signals once in 20 ms, in the program's main thread (elsewhere Python has none), and throws what
/// their handlers raise, such as KeyboardInterrupt.
class SignalCheck {
 public:
  void operator()() {
    const std::int64_t now_ns = SteadyNanoseconds();
    if (now_ns - looked_ns_ < kEvery_ns) return;
    looked_ns_ = now_ns;
    const pybind11::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  static constexpr std::int64_t kEvery_ns = 20'000'000;
  std::int64_t looked_ns_ = SteadyNanoseconds();
};

}  // namespace palpate
