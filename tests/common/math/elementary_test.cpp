#include "common/math/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Distance from the truth, in units in the last place of a double of that size.
double Ulps(double value, long double truth) {
  const double near = std::abs(static_cast<double>(truth));
  const double ulp = std::nextafter(near, kInfinity) - near;
  return static_cast<double>(std::abs(value - truth) / ulp);
}

/// Calls check(x) with many x between `low` and `high`.
template <typename Check>
void Over(double low, double high, Check check) {
  test::Random random(7);
  for (int i = 0; i < 100000; ++i) check(random.Uniform(low, high));
}

TEST(Elementary, IsTrueToFewUnitsInTheLastPlace) {
  double sine = 0.0, exponential = 0.0, logarithm = 0.0, angle = 0.0;
  Over(-1e5, 1e5, [&](double x) {
    // Beside a zero the reduction by a pi/2 of 119 bits leaves an absolute error instead.
    if (std::abs(std::sin(x)) > 1e-3) sine = std::max(sine, Ulps(Sin(x), std::sin((long double)x)));
    if (std::abs(std::cos(x)) > 1e-3) sine = std::max(sine, Ulps(Cos(x), std::cos((long double)x)));
  });
  Over(-700.0, 700.0, [&](double x) {
    exponential = std::max(exponential, Ulps(Exp(x), std::exp((long double)x)));
    const double power = Exp(x);
    logarithm = std::max(logarithm, Ulps(Log(power), std::log((long double)power)));
  });
  Over(0.5, 2.0,
       [&](double x) { logarithm = std::max(logarithm, Ulps(Log(x), std::log((long double)x))); });
  Over(-4.0, 4.0, [&](double a) {
    const double y = std::sin(a), x = std::cos(a);
    angle = std::max(angle, Ulps(Atan2(y, x), std::atan2((long double)y, (long double)x)));
  });
  EXPECT_LE(sine, 3.0);
  EXPECT_LE(exponential, 3.0);
  EXPECT_LE(logarithm, 3.0);
  EXPECT_LE(angle, 5.0);
}

TEST(Elementary, RaisesToAPower) {
  test::Random random(11);
  for (int i = 0; i < 100000; ++i) {
    const double x = random.Uniform(0.0, 30.0), y = random.Uniform(-4.0, 4.0);
    const long double truth = std::pow((long double)x, (long double)y);
    EXPECT_LE(Ulps(Pow(x, y), truth), 2.0 + 2.0 * std::abs(y * std::log(x))) << x << ' ' << y;
  }
}

TEST(Elementary, HasTheValuesAtTheEdgesThatTheStandardGives) {
  EXPECT_EQ(Sin(0.0), 0.0);
  EXPECT_EQ(Cos(0.0), 1.0);
  EXPECT_EQ(Exp(0.0), 1.0);
  EXPECT_EQ(Log(1.0), 0.0);
  EXPECT_EQ(Exp(-800.0), 0.0);
  EXPECT_EQ(Exp(800.0), kInfinity);
  EXPECT_EQ(Log(0.0), -kInfinity);
  EXPECT_EQ(Log(kInfinity), kInfinity);
  EXPECT_EQ(Pow(0.0, 2.4), 0.0);
  EXPECT_EQ(Pow(0.0, 0.0), 1.0);
  EXPECT_EQ(Pow(0.0, -1.0), kInfinity);
  for (const double wrong : {std::nan(""), kInfinity, -kInfinity}) {
    EXPECT_TRUE(std::isnan(Sin(wrong)));
    EXPECT_TRUE(std::isnan(Cos(wrong)));
  }
  EXPECT_TRUE(std::isnan(Exp(std::nan(""))));
  EXPECT_TRUE(std::isnan(Log(-1.0)));
  EXPECT_TRUE(std::isnan(Pow(-1.0, 0.5)));
  for (const double y : {-1.0, -0.0, 0.0, 1.0}) {
    for (const double x : {-1.0, 1.0}) EXPECT_NEAR(Atan2(y, x), std::atan2(y, x), 1e-15);
    EXPECT_EQ(Atan2(y, 0.0), y == 0.0 ? 0.0 : std::atan2(y, 0.0));
  }
  EXPECT_EQ(Length(3.0, -4.0), 5.0);
}

}  // namespace
}  // namespace palpate
