#include "client/recorder/sample_queue.h"

#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(SampleQueue, GivesSamplesBackInTheirOrder) {
  SampleQueue queue(1000);
  std::int64_t time_ns = 5;
  const auto clock = [&] { return time_ns++; };
  EXPECT_TRUE(queue.Put(7, clock, Bytes{1, 2}, Bytes{3}));
  EXPECT_TRUE(queue.Put(8, clock, Bytes{}));
  Bytes drained;
  queue.Swap(drained);
  int count = 0;
  SampleQueue::ForEach(drained, [&](const SampleQueue::Head& head, auto bytes) {
    EXPECT_EQ(head.time_ns, 5 + count);
    EXPECT_EQ(head.channel, 7u + static_cast<unsigned>(count));
    EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), count == 0 ? (Bytes{1, 2, 3}) : Bytes{});
    ++count;
  });
  EXPECT_EQ(count, 2);
  queue.Swap(drained);
  EXPECT_TRUE(drained.empty());
}

TEST(SampleQueue, RefusesWhatHasNoRoomAndTakesMoreOnceItIsEmptied) {
  SampleQueue queue(3 * (sizeof(SampleQueue::Head) + 10));
  const auto clock = [] { return std::int64_t{0}; };
  const Bytes sample(10);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.Put(0, clock, sample));
  EXPECT_FALSE(queue.Put(0, clock, sample));
  Bytes drained;
  queue.Swap(drained);
  EXPECT_TRUE(queue.Put(0, clock, sample));
}

TEST(SampleQueue, LosesNothingBetweenThreads) {
  SampleQueue queue(std::size_t{1} << 24);
  constexpr int kEach = 20000;
  std::int64_t ticks = 0;
  const auto produce = [&](std::uint32_t channel) {
    for (std::uint32_t i = 0; i < kEach; ++i) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&i);
      ASSERT_TRUE(queue.Put(channel, [&] { return ++ticks; }, {bytes, sizeof i}));
    }
  };
  std::thread a(produce, 0u), b(produce, 1u);
  std::uint32_t next[2] = {0, 0};
  std::int64_t time_ns = 0;
  Bytes drained;
  while (next[0] + next[1] < 2 * kEach) {
    queue.Swap(drained);
    SampleQueue::ForEach(drained, [&](const SampleQueue::Head& head, auto bytes) {
      std::uint32_t value;
      ASSERT_EQ(bytes.size(), sizeof value);
      std::memcpy(&value, bytes.data(), sizeof value);
      EXPECT_EQ(value, next[head.channel]++);
      EXPECT_EQ(head.time_ns, ++time_ns);
    });
  }
  a.join();
  b.join();
}

}  // namespace
}  // namespace palpate
