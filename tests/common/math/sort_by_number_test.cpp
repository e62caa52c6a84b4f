#include "common/math/sort_by_number.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate {
namespace {

struct Item {
  std::uint32_t first, second;
  int place;
  bool operator==(const Item&) const = default;
};

TEST(SortByNumber, SortsByTwoNumbersAndKeepsTheOrderOfWhatHasTheSame) {
  constexpr std::uint32_t kEnd = 40;  // small, so that many items have equal numbers
  test::Random random(3);
  for (const int count : {0, 1, 5000}) {
    std::vector<Item> items;
    const auto number = [&] { return static_cast<std::uint32_t>(random.Uniform(0.0, kEnd)); };
    for (int place = 0; place < count; ++place) items.push_back({number(), number(), place});
    std::vector<Item> expected = items;
    std::ranges::sort(expected, {},
                      [](const Item& i) { return std::tuple(i.first, i.second, i.place); });
    SortByNumber(items, kEnd, &Item::second);
    SortByNumber(items, kEnd, [](const Item& item) { return item.first; });
    EXPECT_EQ(items, expected);
  }
}

}  // namespace
}  // namespace palpate
