#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// Deterministic random numbers, the same on every platform (the standard library's distributions
/// are not). splitmix64, Steele et al., OOPSLA 2014.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t Bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(Bits() >> 11) * 0x1.0p-53;
  }
  int Below(int n) { return static_cast<int>(Bits() % static_cast<std::uint64_t>(n)); }
  Vec3 InCube(double half) {
    const double x = Uniform(-half, half), y = Uniform(-half, half);
    return {x, y, Uniform(-half, half)};
  }
  Vec3 Direction() {
    for (;;) {
      const Vec3 v = InCube(1.0);
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  }
  Quat Rotation() { return RotationExp(Uniform(0.0, 3.1) * Direction()); }

 private:
  std::uint64_t state_;
};

}  // namespace palpate
