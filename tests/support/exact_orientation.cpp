#include "tests/support/exact_orientation.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace palpate::test {
namespace {

constexpr double kEpsilon = 0x1.0p-53;  // of rounding to nearest, relative
// Shewchuk's bounds for the first estimates, ccwerrboundA and o3derrboundA.
constexpr double kOrient2dBound = (3.0 + 16.0 * kEpsilon) * kEpsilon;
constexpr double kOrient3dBound = (7.0 + 56.0 * kEpsilon) * kEpsilon;

int Sign(double x) {
  return (x > 0.0) - (x < 0.0);
}

/// An exact number as a sum of at most N doubles.  The terms do not overlap and increase in
/// magnitude (zeros are left out), so the last one has the sign of the sum.
template <std::size_t N>
struct Expansion {
  std::array<double, N> term;
  std::size_t size = 0;

  /// The exact sum with one more double (Grow-Expansion).
  void Add(double b) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double a = term[i], sum = a + b;
      const double b_part = sum - a, a_part = sum - b_part;
      const double rest = (a - a_part) + (b - b_part);
      if (rest != 0.0) term[kept++] = rest;
      b = sum;
    }
    if (b != 0.0) term[kept++] = b;
    size = kept;
  }
  int sign() const { return size == 0 ? 0 : Sign(term[size - 1]); }
};

Expansion<2> Difference(double a, double b) {
  Expansion<2> out;
  out.Add(a);
  out.Add(-b);
  return out;
}

template <std::size_t N, std::size_t M>
Expansion<2 * N * M> Product(const Expansion<N>& a, const Expansion<M>& b) {
  Expansion<2 * N * M> out;
  for (std::size_t i = 0; i < a.size; ++i) {
    for (std::size_t j = 0; j < b.size; ++j) {
      const double high = a.term[i] * b.term[j];
      out.Add(std::fma(a.term[i], b.term[j], -high));
      out.Add(high);
    }
  }
  return out;
}

template <std::size_t N>
Expansion<2 * N> Minus(const Expansion<N>& a, const Expansion<N>& b) {
  Expansion<2 * N> out;
  for (std::size_t i = 0; i < a.size; ++i) out.Add(a.term[i]);
  for (std::size_t i = 0; i < b.size; ++i) out.Add(-b.term[i]);
  return out;
}

/// The exact difference of two points.
using ExactVector = std::array<Expansion<2>, 3>;
ExactVector Relative(const Vec3& a, const Vec3& origin) {
  return {Difference(a.x(), origin.x()), Difference(a.y(), origin.y()),
          Difference(a.z(), origin.z())};
}

Expansion<16> Determinant2(const Expansion<2>& a, const Expansion<2>& b, const Expansion<2>& c,
                           const Expansion<2>& d) {
  return Minus(Product(a, d), Product(b, c));
}

int ExactOrient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const ExactVector u = Relative(a, d), v = Relative(b, d), w = Relative(c, d);
  Expansion<192> sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const auto part = Product(u[i], Determinant2(v[j], v[k], w[j], w[k]));
    for (std::size_t t = 0; t < part.size; ++t) sum.Add(part.term[t]);
  }
  return sum.sign();
}

}  // namespace

int Orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d, v = b - d, w = c - d;
  double determinant = 0.0, permanent = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double vw = v[j] * w[k], wv = v[k] * w[j];
    determinant += u[i] * (vw - wv);
    permanent += std::abs(u[i]) * (std::abs(vw) + std::abs(wv));
  }
  if (std::abs(determinant) > kOrient3dBound * permanent) return Sign(determinant);
  return ExactOrient3d(a, b, c, d);
}

int Orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  const double left = (a[x] - c[x]) * (b[y] - c[y]), right = (a[y] - c[y]) * (b[x] - c[x]);
  const double determinant = left - right;
  if (std::abs(determinant) > kOrient2dBound * (std::abs(left) + std::abs(right))) {
    return Sign(determinant);
  }
  return Determinant2(Difference(a[x], c[x]), Difference(a[y], c[y]), Difference(b[x], c[x]),
                      Difference(b[y], c[y]))
      .sign();
}

}  // namespace palpate::test
