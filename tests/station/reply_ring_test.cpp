#include <thread>

#include <gtest/gtest.h>

#include "client/station/reply.h"

namespace palpate {
namespace {

Reply Numbered(std::uint64_t n) {
  Reply reply;
  reply.pose_sequence = n;
  reply.wrench.force = Vec3::Constant(static_cast<double>(n));
  return reply;
}

TEST(ReplyRing, GivesRepliesInTheirOrderAndRefusesWhatDoesNotFit) {
  ReplyRing ring;
  Reply reply;
  EXPECT_FALSE(ring.Pop(reply));
  for (std::uint64_t n = 0; n < ReplyRing::kCapacity; ++n) EXPECT_TRUE(ring.Push(Numbered(n)));
  EXPECT_FALSE(ring.Push(Numbered(0)));
  for (std::uint64_t n = 0; n < ReplyRing::kCapacity; ++n) {
    ASSERT_TRUE(ring.Pop(reply));
    EXPECT_EQ(reply.pose_sequence, n);
  }
  EXPECT_FALSE(ring.Pop(reply));
  EXPECT_TRUE(ring.Push(Numbered(1)));
}

TEST(ReplyRing, CarriesWholeRepliesBetweenTwoThreads) {
  constexpr std::uint64_t kReplies = 100'000;
  ReplyRing ring;
  std::thread producer([&ring] {
    for (std::uint64_t n = 1; n <= kReplies;) {
      if (ring.Push(Numbered(n))) {
        ++n;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t n = 1; n <= kReplies;) {
    Reply reply;
    if (!ring.Pop(reply)) {
      std::this_thread::yield();
      continue;
    }
    wrong += reply.pose_sequence != n || reply.wrench.force.z() != static_cast<double>(n);
    ++n;
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace palpate
