#include "common/realtime/latest_mailbox.h"

#include <array>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Large enough that a torn copy shows.
using Block = std::array<std::uint64_t, 64>;

TEST(LatestMailbox, HasNothingBeforeTheFirstWrite) {
  LatestMailbox<int> mailbox;
  int value = 7;
  EXPECT_FALSE(mailbox.Read(value));
  EXPECT_EQ(value, 7);
}

TEST(LatestMailbox, GivesTheLatestValueOnce) {
  LatestMailbox<int> mailbox;
  for (int i = 1; i <= 5; ++i) mailbox.Write(i);
  int value = 0;
  EXPECT_TRUE(mailbox.Read(value));
  EXPECT_EQ(value, 5);
  EXPECT_FALSE(mailbox.Read(value));
}

TEST(LatestMailbox, NeverTearsNorGoesBackBetweenTwoThreads) {
  constexpr std::uint64_t kWrites = 200'000;
  LatestMailbox<Block> mailbox;
  std::thread writer([&] {
    Block block;
    for (std::uint64_t i = 1; i <= kWrites; ++i) {
      block.fill(i);
      mailbox.Write(block);
    }
  });
  std::uint64_t last = 0;
  std::uint64_t torn = 0;
  std::uint64_t backward = 0;
  Block block{};
  while (last < kWrites) {
    if (!mailbox.Read(block)) {
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t word : block) torn += word != block[0];
    backward += block[0] <= last;
    last = block[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backward, 0u);
}

}  // namespace
}  // namespace palpate
