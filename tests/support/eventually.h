#pragma once

#include <chrono>
#include <thread>

namespace palpate::test {

/// Tests a condition each millisecond until it holds; false after far longer than any stall.
template <class Condition>
bool Eventually(Condition condition, double seconds = 30.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace palpate::test
