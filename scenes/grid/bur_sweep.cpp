#include "scenes/grid/bur_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace palpate {
namespace {

constexpr int kFour = 4;
using Four = double __attribute__((vector_size(kFour * sizeof(double))));
using FourFloats = float __attribute__((vector_size(kFour * sizeof(float))));
using SweptCurve = BurSweep::Curve;
/// Places on a bur's way that are tried between its ends: taken.
constexpr int kTurns = 3;

inline Four All(double v) {
  return Four{} + v;
}

namespace any {
inline Four Root(Four v) {
  for (int n = 0; n < kFour; ++n) v[n] = std::sqrt(v[n]);
  return v;
}
template <class Holds>
bool Are(Holds holds) {
  return (holds[0] & holds[1] & holds[2] & holds[3]) != 0;
}
#include "scenes/grid/bur_sweep.inl"
}  // namespace any

// Without fused multiplication, and so with the same bits.
#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
inline Four Root(Four v) {
  return _mm256_sqrt_pd(v);
}
template <class Holds>
bool Are(Holds holds) {
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(holds)) == 15;
}
#include "scenes/grid/bur_sweep.inl"
}  // namespace avx2
#pragma GCC pop_options
#endif

}  // namespace

BurSweep::BurSweep(const Bur& bur, const Vec3& step_T) {
  curve_.count = bur.count_;
  curve_.rounding = bur.rounding_;
  for (std::size_t n = 0; n < Bur::kMostPoints; ++n) {
    curve_.rho[n] = bur.points_[n].rho;
    curve_.z[n] = bur.points_[n].z;
    curve_.rho_normal[n] = bur.normals_[n].rho;
    curve_.z_normal[n] = bur.normals_[n].z;
    curve_.inverse_squared[n] = bur.inverse_squared_[n];
  }
  std::copy_n(step_T.data(), 3, curve_.step);
  curve_.step_squared = step_T.squaredNorm();
  curve_.inverse_step_squared = curve_.step_squared > 0.0 ? 1.0 / curve_.step_squared : 0.0;
}

bool BurSweep::IsWide() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

void BurSweep::Distances(const Vec3& first_T, const Vec3& apart_T, const Row& within,
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
