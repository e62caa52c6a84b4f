#include "common/realtime/append_log.h"

#include <array>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(AppendLog, KeepsWhatIsAppendedInItsOrderUntilFull) {
  AppendLog<int> log(3);
  EXPECT_EQ(log.size(), 0u);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(log.Append(10 + i));
  EXPECT_FALSE(log.Append(99));
  ASSERT_EQ(log.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(log[i], 10 + static_cast<int>(i));
}

TEST(AppendLog, ShowsWholeValuesToAThreadThatReadsMeanwhile) {
  constexpr std::size_t kValues = 100'000;
  using Block = std::array<std::uint64_t, 8>;
  AppendLog<Block> log(kValues);
  std::thread writer([&] {
    Block block;
    for (std::size_t i = 0; i < kValues; ++i) {
      block.fill(i + 1);
      log.Append(block);
    }
  });
  std::size_t read = 0, wrong = 0;
  while (read < kValues) {
    for (const std::size_t size = log.size(); read < size; ++read) {
      for (const std::uint64_t word : log[read]) wrong += word != read + 1;
    }
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace palpate
