#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Vectors of sixteen floats or eight doubles, for the instruction set of the including file:
// AVX-512, AVX2 with FMA, or plain C++.  Every operation is the IEEE operation lane by lane, a
// fused multiply-add only where Fma is written, so all three give the same bits.
//
// Everything has internal linkage, and no header with inline functions of its own is included: a
// COMDAT compiled for AVX-512 must never be the one that the linker keeps for an older processor.
namespace palpate {
namespace {

#if defined(__AVX512F__)

struct F16 {
  __m512 v;
};
inline F16 operator-(F16 a, F16 b) {
  return {_mm512_sub_ps(a.v, b.v)};
}
inline F16 operator+(F16 a, F16 b) {
  return {_mm512_add_ps(a.v, b.v)};
}
inline F16 operator*(F16 a, F16 b) {
  return {_mm512_mul_ps(a.v, b.v)};
}
inline F16 Fma(F16 a, F16 b, F16 c) {
  return {_mm512_fmadd_ps(a.v, b.v, c.v)};
}
inline F16 Set1(float a) {
  return {_mm512_set1_ps(a)};
}
/// Returns p[0..7] twice.
inline F16 LoadTwice(const float* p) {
  return {_mm512_broadcast_f32x8(_mm256_load_ps(p))};
}
inline void StoreFirst8(float* p, F16 a) {
  _mm256_store_ps(p, _mm512_castps512_ps256(a.v));
}
/// Returns p[2k] eight times, then p[2k + 1] eight times.
template <int k>
inline F16 SpreadPair(F16 twice) {
  const __m512i index =
      _mm512_set_epi32(2 * k + 1, 2 * k + 1, 2 * k + 1, 2 * k + 1, 2 * k + 1, 2 * k + 1, 2 * k + 1,
                       2 * k + 1, 2 * k, 2 * k, 2 * k, 2 * k, 2 * k, 2 * k, 2 * k, 2 * k);
  return {_mm512_permutexvar_ps(index, twice.v)};
}
inline std::uint32_t LessEqual(F16 a, F16 b) {
  return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ);
}

struct D8 {
  __m512d v;
};
/// p must be aligned to 64 bytes; that of Store need not be.
inline D8 Load(const double* p) {
  return {_mm512_load_pd(p)};
}
inline void Store(double* p, D8 a) {
  _mm512_storeu_pd(p, a.v);
}
inline D8 Set1(double a) {
  return {_mm512_set1_pd(a)};
}
inline D8 operator-(D8 a, D8 b) {
  return {_mm512_sub_pd(a.v, b.v)};
}
inline D8 operator+(D8 a, D8 b) {
  return {_mm512_add_pd(a.v, b.v)};
}
inline D8 operator*(D8 a, D8 b) {
  return {_mm512_mul_pd(a.v, b.v)};
}
inline D8 operator/(D8 a, D8 b) {
  return {_mm512_div_pd(a.v, b.v)};
}
inline D8 Fma(D8 a, D8 b, D8 c) {
  return {_mm512_fmadd_pd(a.v, b.v, c.v)};
}
/// c - a * b, rounded once.
inline D8 Fnma(D8 a, D8 b, D8 c) {
  return {_mm512_fnmadd_pd(a.v, b.v, c.v)};
}
inline D8 Sqrt(D8 a) {
  return {_mm512_sqrt_pd(a.v)};
}
/// Lane by lane: a < b ? x : y.
inline D8 SelectLess(D8 a, D8 b, D8 x, D8 y) {
  return {_mm512_mask_blend_pd(_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ), y.v, x.v)};
}
/// Lane by lane: a < b ? a : b.  Saves the comparison of SelectLess.
inline D8 Min(D8 a, D8 b) {
  return {_mm512_min_pd(a.v, b.v)};
}
/// Sets bit i if lane i of a is less than lane i of b.
inline std::uint32_t Less(D8 a, D8 b) {
  return _mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ);
}
/// Returns a in the lanes whose bits are set, b in the others.
inline D8 SelectLanes(std::uint32_t bits, D8 a, D8 b) {
  return {_mm512_mask_blend_pd(static_cast<__mmask8>(bits), b.v, a.v)};
}
/// Returns the least lane.
inline double LeastLane(D8 a) {
  const __m256d four = _mm256_min_pd(_mm512_extractf64x4_pd(a.v, 1), _mm512_castpd512_pd256(a.v));
  const __m128d two = _mm_min_pd(_mm256_extractf128_pd(four, 1), _mm256_castpd256_pd128(four));
  return _mm_cvtsd_f64(_mm_min_sd(_mm_unpackhi_pd(two, two), two));
}
/// Lane i is p[at[i]]; at[i] is in 0 to 6.
inline D8 Spread(const double* p, const long long* at) {
  return {_mm512_permutexvar_pd(_mm512_load_si512(at), _mm512_maskz_loadu_pd(0x7f, p))};
}
/// Transposes eight records of four doubles into four vectors, one per field.
inline void LoadTransposed(const double* const record[8], D8 field[4]) {
  const auto pair = [&](int i) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(record[i])),
                              _mm256_load_pd(record[i + 4]), 1);
  };
  const __m512d r0 = pair(0), r1 = pair(1), r2 = pair(2), r3 = pair(3);
  // Within each 256-bit half, a 4 x 4 transpose; halves hold lanes 0-3 and 4-7.
  const __m512d t0 = _mm512_unpacklo_pd(r0, r1), t1 = _mm512_unpackhi_pd(r0, r1);
  const __m512d t2 = _mm512_unpacklo_pd(r2, r3), t3 = _mm512_unpackhi_pd(r2, r3);
  const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0);
  const __m512i high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
  field[0] = {_mm512_permutex2var_pd(t0, low, t2)};
  field[1] = {_mm512_permutex2var_pd(t1, low, t3)};
  field[2] = {_mm512_permutex2var_pd(t0, high, t2)};
  field[3] = {_mm512_permutex2var_pd(t1, high, t3)};
}

#elif defined(__AVX2__)

struct F16 {
  __m256 a, b;
};
inline F16 operator-(F16 x, F16 y) {
  return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)};
}
inline F16 operator+(F16 x, F16 y) {
  return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)};
}
inline F16 operator*(F16 x, F16 y) {
  return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)};
}
inline F16 Fma(F16 x, F16 y, F16 z) {
  return {_mm256_fmadd_ps(x.a, y.a, z.a), _mm256_fmadd_ps(x.b, y.b, z.b)};
}
inline F16 Set1(float x) {
  return {_mm256_set1_ps(x), _mm256_set1_ps(x)};
}
inline F16 LoadTwice(const float* p) {
  const __m256 v = _mm256_load_ps(p);
  return {v, v};
}
inline void StoreFirst8(float* p, F16 x) {
  _mm256_store_ps(p, x.a);
}
template <int k>
inline F16 SpreadPair(F16 twice) {
  return {_mm256_permutevar8x32_ps(twice.a, _mm256_set1_epi32(2 * k)),
          _mm256_permutevar8x32_ps(twice.a, _mm256_set1_epi32(2 * k + 1))};
}
inline std::uint32_t LessEqual(F16 x, F16 y) {
  const auto bits = [](__m256 u, __m256 w) {
    return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(u, w, _CMP_LE_OQ)));
  };
  return bits(x.a, y.a) | bits(x.b, y.b) << 8;
}

struct D8 {
  __m256d a, b;
};
inline D8 Load(const double* p) {
  return {_mm256_load_pd(p), _mm256_load_pd(p + 4)};
}
inline void Store(double* p, D8 x) {
  _mm256_storeu_pd(p, x.a);
  _mm256_storeu_pd(p + 4, x.b);
}
inline D8 Set1(double x) {
  return {_mm256_set1_pd(x), _mm256_set1_pd(x)};
}
inline D8 operator-(D8 x, D8 y) {
  return {_mm256_sub_pd(x.a, y.a), _mm256_sub_pd(x.b, y.b)};
}
inline D8 operator+(D8 x, D8 y) {
  return {_mm256_add_pd(x.a, y.a), _mm256_add_pd(x.b, y.b)};
}
inline D8 operator*(D8 x, D8 y) {
  return {_mm256_mul_pd(x.a, y.a), _mm256_mul_pd(x.b, y.b)};
}
inline D8 operator/(D8 x, D8 y) {
  return {_mm256_div_pd(x.a, y.a), _mm256_div_pd(x.b, y.b)};
}
inline D8 Fma(D8 x, D8 y, D8 z) {
  return {_mm256_fmadd_pd(x.a, y.a, z.a), _mm256_fmadd_pd(x.b, y.b, z.b)};
}
inline D8 Fnma(D8 x, D8 y, D8 z) {
  return {_mm256_fnmadd_pd(x.a, y.a, z.a), _mm256_fnmadd_pd(x.b, y.b, z.b)};
}
inline D8 Sqrt(D8 x) {
  return {_mm256_sqrt_pd(x.a), _mm256_sqrt_pd(x.b)};
}
inline D8 SelectLess(D8 x, D8 y, D8 u, D8 w) {
  return {_mm256_blendv_pd(w.a, u.a, _mm256_cmp_pd(x.a, y.a, _CMP_LT_OQ)),
          _mm256_blendv_pd(w.b, u.b, _mm256_cmp_pd(x.b, y.b, _CMP_LT_OQ))};
}
inline D8 Min(D8 x, D8 y) {
  return {_mm256_min_pd(x.a, y.a), _mm256_min_pd(x.b, y.b)};
}
inline std::uint32_t Less(D8 x, D8 y) {
  return static_cast<std::uint32_t>(_mm256_movemask_pd(_mm256_cmp_pd(x.a, y.a, _CMP_LT_OQ)) |
                                    _mm256_movemask_pd(_mm256_cmp_pd(x.b, y.b, _CMP_LT_OQ)) << 4);
}
inline D8 SelectLanes(std::uint32_t bits, D8 x, D8 y) {
  const __m256i all = _mm256_set1_epi64x(bits);
  const auto is_set = [&](long long first) {
    const __m256i bit = _mm256_set_epi64x(8 * first, 4 * first, 2 * first, first);
    return _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(all, bit), bit));
  };
  return {_mm256_blendv_pd(y.a, x.a, is_set(1)), _mm256_blendv_pd(y.b, x.b, is_set(16))};
}
inline double LeastLane(D8 x) {
  const __m256d four = _mm256_min_pd(x.b, x.a);
  const __m128d two = _mm_min_pd(_mm256_extractf128_pd(four, 1), _mm256_castpd256_pd128(four));
  return _mm_cvtsd_f64(_mm_min_sd(_mm_unpackhi_pd(two, two), two));
}
inline D8 Spread(const double* p, const long long* at) {
  return {_mm256_set_pd(p[at[3]], p[at[2]], p[at[1]], p[at[0]]),
          _mm256_set_pd(p[at[7]], p[at[6]], p[at[5]], p[at[4]])};
}
inline void LoadTransposed(const double* const record[8], D8 field[4]) {
  const auto half = [&](int first, __m256d out[4]) {
    const __m256d r0 = _mm256_load_pd(record[first]), r1 = _mm256_load_pd(record[first + 1]);
    const __m256d r2 = _mm256_load_pd(record[first + 2]), r3 = _mm256_load_pd(record[first + 3]);
    const __m256d t0 = _mm256_unpacklo_pd(r0, r1), t1 = _mm256_unpackhi_pd(r0, r1);
    const __m256d t2 = _mm256_unpacklo_pd(r2, r3), t3 = _mm256_unpackhi_pd(r2, r3);
    out[0] = _mm256_permute2f128_pd(t0, t2, 0x20);
    out[1] = _mm256_permute2f128_pd(t1, t3, 0x20);
    out[2] = _mm256_permute2f128_pd(t0, t2, 0x31);
    out[3] = _mm256_permute2f128_pd(t1, t3, 0x31);
  };
  __m256d low[4], high[4];
  half(0, low);
  half(4, high);
  for (int f = 0; f < 4; ++f) field[f] = {low[f], high[f]};
}

#else

struct F16 {
  float v[16];
};
template <class Op>
inline F16 EachFloat(Op op) {
  F16 r;
  for (int i = 0; i < 16; ++i) r.v[i] = op(i);
  return r;
}
inline F16 operator-(const F16& a, const F16& b) {
  return EachFloat([&](int i) { return a.v[i] - b.v[i]; });
}
inline F16 operator+(const F16& a, const F16& b) {
  return EachFloat([&](int i) { return a.v[i] + b.v[i]; });
}
inline F16 operator*(const F16& a, const F16& b) {
  return EachFloat([&](int i) { return a.v[i] * b.v[i]; });
}
inline F16 Fma(const F16& a, const F16& b, const F16& c) {
  return EachFloat([&](int i) { return __builtin_fmaf(a.v[i], b.v[i], c.v[i]); });
}
inline F16 Set1(float a) {
  return EachFloat([&](int) { return a; });
}
inline F16 LoadTwice(const float* p) {
  return EachFloat([&](int i) { return p[i & 7]; });
}
inline void StoreFirst8(float* p, const F16& a) {
  for (int i = 0; i < 8; ++i) p[i] = a.v[i];
}
template <int k>
inline F16 SpreadPair(const F16& twice) {
  return EachFloat([&](int i) { return twice.v[2 * k + (i >> 3)]; });
}
inline std::uint32_t LessEqual(const F16& a, const F16& b) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 16; ++i) bits |= static_cast<std::uint32_t>(a.v[i] <= b.v[i]) << i;
  return bits;
}

struct D8 {
  double v[8];
};
template <class Op>
inline D8 EachDouble(Op op) {
  D8 r;
  for (int i = 0; i < 8; ++i) r.v[i] = op(i);
  return r;
}
inline D8 Load(const double* p) {
  return EachDouble([&](int i) { return p[i]; });
}
inline void Store(double* p, const D8& a) {
  for (int i = 0; i < 8; ++i) p[i] = a.v[i];
}
inline D8 Set1(double a) {
  return EachDouble([&](int) { return a; });
}
inline D8 operator-(const D8& a, const D8& b) {
  return EachDouble([&](int i) { return a.v[i] - b.v[i]; });
}
inline D8 operator+(const D8& a, const D8& b) {
  return EachDouble([&](int i) { return a.v[i] + b.v[i]; });
}
inline D8 operator*(const D8& a, const D8& b) {
  return EachDouble([&](int i) { return a.v[i] * b.v[i]; });
}
inline D8 operator/(const D8& a, const D8& b) {
  return EachDouble([&](int i) { return a.v[i] / b.v[i]; });
}
inline D8 Fma(const D8& a, const D8& b, const D8& c) {
  return EachDouble([&](int i) { return __builtin_fma(a.v[i], b.v[i], c.v[i]); });
}
inline D8 Fnma(const D8& a, const D8& b, const D8& c) {
  return EachDouble([&](int i) { return __builtin_fma(-a.v[i], b.v[i], c.v[i]); });
}
inline D8 Sqrt(const D8& a) {
  return EachDouble([&](int i) { return __builtin_sqrt(a.v[i]); });
}
inline D8 SelectLess(const D8& a, const D8& b, const D8& x, const D8& y) {
  return EachDouble([&](int i) { return a.v[i] < b.v[i] ? x.v[i] : y.v[i]; });
}
inline D8 Min(const D8& a, const D8& b) {
  return EachDouble([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
}
inline std::uint32_t Less(const D8& a, const D8& b) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= static_cast<std::uint32_t>(a.v[i] < b.v[i]) << i;
  return bits;
}
inline D8 SelectLanes(std::uint32_t bits, const D8& a, const D8& b) {
  return EachDouble([&](int i) { return (bits >> i & 1u) != 0 ? a.v[i] : b.v[i]; });
}
inline double LeastLane(D8 a) {
  for (int half = 4; half > 0; half /= 2) {
    for (int i = 0; i < half; ++i) a.v[i] = a.v[i + half] < a.v[i] ? a.v[i + half] : a.v[i];
  }
  return a.v[0];
}
inline D8 Spread(const double* p, const long long* at) {
  return EachDouble([&](int i) { return p[at[i]]; });
}
inline void LoadTransposed(const double* const record[8], D8 field[4]) {
  for (int f = 0; f < 4; ++f) field[f] = EachDouble([&](int i) { return record[i][f]; });
}

#endif

/// W vectors as one of 8 W doubles.
template <int W>
struct Wide {
  D8 part[W];
};
template <int W>
inline Wide<W> SetAll(double a) {
  Wide<W> r;
  for (D8& part : r.part) part = Set1(a);
  return r;
}
template <int W>
inline Wide<W> operator+(const Wide<W>& a, const Wide<W>& b) {
  Wide<W> r;
  for (int i = 0; i < W; ++i) r.part[i] = a.part[i] + b.part[i];
  return r;
}
template <int W>
inline Wide<W> operator-(const Wide<W>& a, const Wide<W>& b) {
  Wide<W> r;
  for (int i = 0; i < W; ++i) r.part[i] = a.part[i] - b.part[i];
  return r;
}
template <int W>
inline Wide<W> operator*(double a, const Wide<W>& b) {
  Wide<W> r;
  for (int i = 0; i < W; ++i) r.part[i] = Set1(a) * b.part[i];
  return r;
}
/// c + a b, and c - a b, rounded once.
template <int W>
inline Wide<W> Fma(double a, const Wide<W>& b, const Wide<W>& c) {
  Wide<W> r;
  for (int i = 0; i < W; ++i) r.part[i] = Fma(Set1(a), b.part[i], c.part[i]);
  return r;
}
template <int W>
inline Wide<W> Fnma(double a, const Wide<W>& b, const Wide<W>& c) {
  Wide<W> r;
  for (int i = 0; i < W; ++i) r.part[i] = Fnma(Set1(a), b.part[i], c.part[i]);
  return r;
}

}  // namespace
}  // namespace palpate
