#include "scenes/grid/bur_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace palpate {
namespace {

using Eight = float __attribute__((vector_size(sizeof(BurSweep::Row))));
using SweptCurve = BurSweep::Curve;
/// Number of regula falsi steps along a bur's way; empirical.
constexpr int kTurns = 3;

constexpr float kHuge = 1e18f;  // its square is finite, too

namespace any {
inline Eight Root(Eight v) {
  for (int n = 0; n < BurSweep::kRow; ++n) v[n] = std::sqrt(v[n]);
  return v;
}
template <class Holds>
bool Are(Holds holds) {
  bool all = true;
  for (int n = 0; n < BurSweep::kRow; ++n) all = all && holds[n] != 0;
  return all;
}
#include "scenes/grid/bur_sweep.inl"
}  // namespace any

// Without fused multiplication, so the bits are the same.
#if defined(__x86_64__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace avx2 {
inline Eight Root(Eight v) {
  return _mm256_sqrt_ps(v);
}
template <class Holds>
bool Are(Holds holds) {
  return _mm256_movemask_ps(reinterpret_cast<__m256>(holds)) == 255;
}
#include "scenes/grid/bur_sweep.inl"
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

}  // namespace

BurSweep::BurSweep(const Bur& bur, const Vec3& step_T) {
  curve_.count = bur.count_;
  curve_.hollow = bur.is_hollow();
  curve_.rounding = static_cast<float>(bur.rounding_);
  for (std::size_t n = 0; n < Bur::kMostPoints; ++n) {
    curve_.rho[n] = static_cast<float>(bur.points_[n].rho);
    curve_.z[n] = static_cast<float>(bur.points_[n].z);
    curve_.rho_normal[n] = static_cast<float>(bur.normals_[n].rho);
    curve_.z_normal[n] = static_cast<float>(bur.normals_[n].z);
    curve_.inverse_squared[n] = static_cast<float>(bur.inverse_squared_[n]);
  }
  for (int a = 0; a < 3; ++a) curve_.step[a] = static_cast<float>(step_T[a]);
  const double squared = step_T.squaredNorm();
  curve_.step_squared = static_cast<float>(squared);
  // A way shorter than a nanometre counts as zero.
  curve_.inverse_step_squared = squared > 1e-18 ? static_cast<float>(1.0 / squared) : 0.0f;
}

bool BurSweep::IsWide() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

void BurSweep::Distances(const Vec3& first_T, const Vec3& apart_T, float within,
                         Row& distance) const noexcept {
#if defined(__x86_64__)
  if (IsWide()) return avx2::Distances(curve_, first_T, apart_T, within, distance);
#endif
  any::Distances(curve_, first_T, apart_T, within, distance);
}

BurSweep::Raised BurSweep::Raise(const Vec3& first_T, const Vec3& apart_T, float band, float* phi,
                                 bool wide) const noexcept {
#if defined(__x86_64__)
  if (wide) return avx2::Raise(curve_, first_T, apart_T, band, phi);
#endif
  static_cast<void>(wide);
  return any::Raise(curve_, first_T, apart_T, band, phi);
}

}  // namespace palpate
