#include "client/viewer/frame_queue.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/milliseconds.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr std::uint32_t kStream = 1, kState = 2;

FramePtr MakeFrame(std::uint32_t channel, std::uint64_t instance, std::int64_t number,
                   bool state = false) {
  auto frame = std::make_shared<Frame>();
  frame->channel = channel;
  frame->instance = instance;
  frame->time_ns = number;
  frame->state = state;
  return frame;
}

TEST(FrameQueue, GivesTheNewestOfEachInstanceInTheOrderInWhichTheyCameAndOnlyWhatIsAskedFor) {
  FrameQueue queue;
  queue.Push(MakeFrame(kStream, 1, 1), 0);
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_EQ(queue.Pop(0).frame, nullptr);
  queue.Subscribe(kStream, 70);
  queue.Push(MakeFrame(kStream, 5, 1), 0);
  queue.Push(MakeFrame(kStream, 3, 2), 0);
  queue.Push(MakeFrame(kStream, 5, 3), 0);
  EXPECT_EQ(queue.size(), 2u);
  EXPECT_EQ(queue.lost(), 1u);
  auto next = queue.Pop(0);
  EXPECT_EQ(next.subscription, 70u);
  EXPECT_EQ(next.frame->time_ns, 3);
  EXPECT_TRUE(queue.has_subscription(70));
  queue.Unsubscribe(99);
  EXPECT_EQ(queue.Pop(0).frame->time_ns, 2);
  queue.Unsubscribe(70);
  EXPECT_FALSE(queue.subscribed(kStream));
}

TEST(FrameQueue, NeverDropsTheNewestOfAStateAndCountsNoLossWhereOneIsSuperseded) {
  FrameQueue queue;
  queue.Subscribe(kState, 1);
  for (std::uint64_t change = 0; change < 1000; ++change) {
    queue.Push(MakeFrame(kState, change, 1, true), 0);
    queue.Push(MakeFrame(kState, change, 2, true), 0);
  }
  EXPECT_EQ(queue.lost(), 0u);
  for (int i = 0; i < 1000; ++i) {
    const auto next = queue.Pop(0);
    ASSERT_TRUE(next.frame);
    EXPECT_EQ(next.frame->time_ns, 2);
  }
}

TEST(FrameQueue, HasBoundedMemoryHoweverLongItsViewerStalls) {
  FrameQueue queue;
  queue.Subscribe(kStream, 1);
  const FramePtr watched = MakeFrame(kStream, 1, 0);
  queue.Push(watched, 0);
  for (int i = 0; i < 100'000; ++i) {
    queue.Push(MakeFrame(kStream, static_cast<std::uint64_t>(i % 3), i), i * kMs);
    ASSERT_LE(queue.size(), 3u);
  }
  EXPECT_EQ(watched.use_count(), 1) << "what was superseded is free";
  EXPECT_EQ(queue.lost(), 100'001u - 3u);
}

TEST(FrameQueue, ThinsAStreamToItsRateWithoutCallingThatALoss) {
  FrameQueue queue;
  queue.Subscribe(kStream, 1, 1'000'000'000 / 30);
  int given = 0;
  std::int64_t newest = -1;
  // 60 Hz in, popped 120 times a second, for 10 s.
  for (int tick = 0; tick < 1200; ++tick) {
    const std::int64_t now_ns = tick * 1'000'000'000LL / 120;
    if (tick % 2 == 0) queue.Push(MakeFrame(kStream, 1, tick), now_ns);
    while (const auto next = queue.Pop(now_ns).frame) {
      ++given;
      EXPECT_GT(next->time_ns, newest);
      EXPECT_LE(tick - next->time_ns, 2) << "as new as there is";
      newest = next->time_ns;
    }
  }
  EXPECT_NEAR(given, 300, 2);
  EXPECT_EQ(queue.lost(), 0u);
}

TEST(FrameQueue, CountsAsLostOnlyWhatWasDueWhenASlowViewerWasBusy) {
  FrameQueue queue;
  queue.Subscribe(kStream, 1, 30 * kMs);
  queue.Push(MakeFrame(kStream, 1, 0), 0);
  EXPECT_TRUE(queue.Pop(0).frame);
  queue.Push(MakeFrame(kStream, 1, 1), 10 * kMs);  // early
  EXPECT_FALSE(queue.Pop(10 * kMs).frame);
  queue.Push(MakeFrame(kStream, 1, 2), 20 * kMs);  // replaces an early one
  EXPECT_EQ(queue.lost(), 0u);
  EXPECT_EQ(queue.Pop(30 * kMs).frame->time_ns, 2);
  queue.Push(MakeFrame(kStream, 1, 3), 100 * kMs);
  queue.Push(MakeFrame(kStream, 1, 4), 110 * kMs);
  EXPECT_EQ(queue.lost(), 1u);
}

/// Against a model too simple to be wrong: the newest of each instance since its last pop.
TEST(FrameQueue, AgreesWithASimpleModelInAnyOrderOfCalls) {
  Random random(21);
  FrameQueue queue;
  std::set<std::uint32_t> subscribed;
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::int64_t> newest;
  for (int i = 0; i < 50'000; ++i) {
    const auto channel = static_cast<std::uint32_t>(1 + random.Below(3));
    switch (random.Below(8)) {
      case 0:
        queue.Subscribe(channel, 100 + channel);
        subscribed.insert(channel);
        break;
      case 1:
        queue.Unsubscribe(100 + channel);
        subscribed.erase(channel);
        std::erase_if(newest, [&](const auto& entry) { return entry.first.first == channel; });
        break;
      case 2:
      case 3:
      case 4: {
        const std::uint64_t instance = random.Below(4);
        queue.Push(MakeFrame(channel, instance, i), i);
        if (subscribed.contains(channel)) newest[{channel, instance}] = i;
        break;
      }
      default: {
        const auto next = queue.Pop(i);
        ASSERT_EQ(next.frame != nullptr, !newest.empty());
        if (!next.frame) break;
        const auto found = newest.find({next.frame->channel, next.frame->instance});
        ASSERT_NE(found, newest.end());
        EXPECT_EQ(found->second, next.frame->time_ns);
        EXPECT_EQ(next.subscription, 100 + next.frame->channel);
        newest.erase(found);
      }
    }
    ASSERT_EQ(queue.size(), newest.size());
  }
}

}  // namespace
}  // namespace palpate
