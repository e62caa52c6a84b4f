#include "common/realtime/histogram.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Nearest-rank quantile of all values, the slow way.
std::uint64_t SortedQuantile(std::vector<std::uint64_t> values, double q) {
  std::ranges::sort(values);
  const auto rank =
      static_cast<std::size_t>(std::max(1.0, std::ceil(q * static_cast<double>(values.size()))));
  return values[rank - 1];
}

TEST(Histogram, IsWithinABucketOfTheSortedQuantileAndNeverBelowIt) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> spread(9.0, 2.5);  // 8 us typical, seconds at the far end
  Histogram histogram;
  std::vector<std::uint64_t> values;
  for (int i = 0; i < 20000; ++i) {
    values.push_back(static_cast<std::uint64_t>(spread(random)));
    histogram.Add(static_cast<std::int64_t>(values.back()));
  }
  for (const double q : {0.0, 0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
    const std::uint64_t exact = SortedQuantile(values, q);
    EXPECT_GE(histogram.Quantile(q), exact) << q;
    EXPECT_LE(static_cast<double>(histogram.Quantile(q)), 1.0 + 1.032 * static_cast<double>(exact))
        << q;
  }
  EXPECT_EQ(histogram.max(), *std::ranges::max_element(values));
  EXPECT_EQ(histogram.count(), values.size());
}

TEST(Histogram, IsExactBelow64Nanoseconds) {
  Histogram histogram;
  for (int value = 0; value < 64; ++value) histogram.Add(value);
  for (int rank = 1; rank <= 64; ++rank) EXPECT_EQ(histogram.Quantile(rank / 64.0), rank - 1u);
}

TEST(Histogram, HoldsTheEndsOfEveryPowerOfTwo) {
  for (int bit = 0; bit < 62; ++bit) {
    for (const std::int64_t offset : {-1, 0, 1}) {
      const std::int64_t value = (std::int64_t{1} << bit) + offset;
      Histogram histogram;
      histogram.Add(value);
      EXPECT_EQ(histogram.Quantile(0.5), static_cast<std::uint64_t>(value));
    }
  }
}

TEST(Histogram, CountsANegativeTimeAsNone) {
  Histogram histogram;
  histogram.Add(-5);
  EXPECT_EQ(histogram.count(), 1u);
  EXPECT_EQ(histogram.Quantile(1.0), 0u);
}

TEST(Histogram, OfTwoTogetherIsThatOfAllTheirValues) {
  Histogram both, one, other;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t value = 1 + 7919LL * i * i;
    both.Add(value);
    (i % 3 == 0 ? one : other).Add(value);
  }
  one.Add(other);
  EXPECT_EQ(one.count(), both.count());
  EXPECT_EQ(one.max(), both.max());
  for (const double q : {0.01, 0.5, 0.99}) EXPECT_EQ(one.Quantile(q), both.Quantile(q));
}

TEST(Histogram, IsEmptyWhenCleared) {
  Histogram histogram;
  histogram.Add(1000);
  histogram.Clear();
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.Quantile(0.99), 0u);
}

}  // namespace
}  // namespace palpate
