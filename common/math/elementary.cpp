#include "common/math/elementary.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

/// 1/0!, 1/1!, 1/2! ...
constexpr std::array<double, 20> kInverseFactorial = [] {
  std::array<double, 20> inverse{1.0};
  double factorial = 1.0;
  for (std::size_t k = 1; k < inverse.size(); ++k) inverse[k] = 1.0 / (factorial *= double(k));
  return inverse;
}();

/// Returns x^first / first! - x^(first + 2) / (first + 2)! + ... to x^last / last!.
double Alternating(double x, int first, int last) noexcept {
  const double z = x * x;
  double sum = 0.0;
  for (int k = last; k >= first; k -= 2) sum = kInverseFactorial[std::size_t(k)] - z * sum;
  return first == 1 ? x * sum : sum;
}

/// Returns the sine of x + quarters * pi/2.
double SineOf(double x, int quarters) noexcept {
  // pi/2 in three parts: products of the first two with whole numbers below 2^20 are exact (Cody &
  // Waite, Software Manual for the Elementary Functions, 1980; the parts are those of fdlibm).
  constexpr double kFirst = 1.57079632673412561417, kSecond = 6.07710050630396597660e-11,
                   kThird = 2.02226624879595063154e-21;
  const double turns = std::floor(x * (2.0 / std::numbers::pi) + 0.5);
  if (!(std::abs(turns) < 1e9)) return std::numeric_limits<double>::quiet_NaN();
  const double rest = ((x - turns * kFirst) - turns * kSecond) - turns * kThird;
  const int quadrant = (static_cast<int>(turns) + quarters) & 3;
  const double sine = quadrant & 1 ? Alternating(rest, 0, 18) : Alternating(rest, 1, 17);
  return quadrant & 2 ? -sine : sine;
}

/// ln 2 in two parts: products of the first with exponents of a double are exact.
constexpr double kLn2 = 6.93147180369123816490e-01, kLn2Rest = 1.90821492927058770002e-10;

/// Returns atan(t) for 0 <= t <= 1: two half-angle steps bring t below 0.2, where the series to
/// t^23 is exact to rounding.
double AtanUnit(double t) noexcept {
  t = t / (1.0 + std::sqrt(1.0 + t * t));
  t = t / (1.0 + std::sqrt(1.0 + t * t));
  const double s = t * t;
  double sum = 0.0;
  for (int k = 23; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
  return 4.0 * t * sum;
}

}  // namespace

double Sin(double x) noexcept {
  return SineOf(x, 0);
}

double Cos(double x) noexcept {
  return SineOf(x, 1);
}

double Atan2(double y, double x) noexcept {
  const double s = std::abs(y), c = std::abs(x);
  if (s == 0.0 && c == 0.0) return 0.0;
  const double first =  // in the first quadrant
      s <= c ? AtanUnit(s / c) : 0.5 * std::numbers::pi - AtanUnit(c / s);
  return std::copysign(x < 0.0 ? std::numbers::pi - first : first, y);
}

double Exp(double x) noexcept {
  if (x > 710.0) return std::numeric_limits<double>::infinity();
  if (!(x > -746.0)) return x < 0.0 ? 0.0 : x;  // x is NaN
  const double twos = std::floor(x * (1.0 / std::numbers::ln2) + 0.5);
  const double rest = (x - twos * kLn2) - twos * kLn2Rest;
  double sum = 0.0;
  for (int k = 14; k >= 0; --k) sum = kInverseFactorial[std::size_t(k)] + rest * sum;
  return std::ldexp(sum, static_cast<int>(twos));
}

double Log(double x) noexcept {
  if (!(x > 0.0)) {
    return x == 0.0 ? -std::numeric_limits<double>::infinity()
                    : std::numeric_limits<double>::quiet_NaN();
  }
  if (std::isinf(x)) return x;
  int twos = 0;
  double m = std::frexp(x, &twos);
  if (m < 0.5 * std::numbers::sqrt2) {
    m *= 2.0;
    --twos;
  }
  // log m = 2 atanh((m - 1) / (m + 1)), whose argument is at most 0.172.
  const double s = (m - 1.0) / (m + 1.0), z = s * s;
  double sum = 0.0;
  for (int k = 21; k >= 1; k -= 2) sum = 1.0 / k + z * sum;
  return twos * kLn2 + (2.0 * s * sum + twos * kLn2Rest);
}

double Pow(double x, double y) noexcept {
  if (y == 0.0) return 1.0;
  return Exp(y * Log(x));
}

double Length(double x, double y) noexcept {
  return std::sqrt(x * x + y * y);
}

}  // namespace palpate
