#include "tests/support/allocation_counter.h"

#include <cstdlib>
#include <memory>
#include <new>
#include <thread>
#include <utility>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace palpate::test {
namespace {

/// Keeps the compiler from optimising an allocation away.
void Use(const void* p) {
  asm volatile("" : : "g"(p) : "memory");
}

TEST(AllocationCounter, SeesEveryWayToAskForMemory) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizers bring an allocator of their own";
  std::uint64_t before = AllocationsOfThisThread();
  const auto asked = [&] {
    return AllocationsOfThisThread() - std::exchange(before, AllocationsOfThisThread());
  };
  EXPECT_EQ(asked(), 0u);
  {
    const auto one = std::make_unique<int>(3);
    Use(one.get());
  }
  EXPECT_EQ(asked(), 1u) << "operator new";
  struct alignas(64) Line {
    char bytes[64];
  };
  {
    const auto line = std::make_unique<Line>();
    Use(line.get());
  }
  EXPECT_EQ(asked(), 1u) << "operator new of what is aligned";
  {
    const Eigen::VectorXd vector = Eigen::VectorXd::Ones(9);
    Use(vector.data());
  }
  EXPECT_EQ(asked(), 1u) << "a vector of Eigen's whose size is not known when it is compiled";
  void* p = std::malloc(8);
  Use(p);
  p = std::realloc(p, 4000);
  Use(p);
  std::free(p);
  EXPECT_EQ(asked(), 2u) << "malloc, realloc";
  p = std::calloc(3, 8);
  Use(p);
  std::free(p);
  EXPECT_EQ(asked(), 1u) << "calloc";
  p = std::aligned_alloc(64, 128);
  Use(p);
  std::free(p);
  EXPECT_EQ(asked(), 1u) << "aligned_alloc";
  ASSERT_EQ(posix_memalign(&p, 64, 100), 0);
  Use(p);
  std::free(p);
  EXPECT_EQ(asked(), 1u) << "posix_memalign";
}

TEST(AllocationCounter, LeavesOtherThreadsToThemselves) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizers bring an allocator of their own";
  std::uint64_t here = 0, there = 0;
  std::thread other([&] {
    const std::uint64_t before = AllocationsOfThisThread();
    for (int i = 0; i < 10; ++i) Use(std::make_unique<int>(i).get());
    there = AllocationsOfThisThread() - before;
  });
  const std::uint64_t before = AllocationsOfThisThread();
  other.join();
  here = AllocationsOfThisThread() - before;
  EXPECT_EQ(there, 10u);
  EXPECT_EQ(here, 0u);
}

}  // namespace
}  // namespace palpate::test
