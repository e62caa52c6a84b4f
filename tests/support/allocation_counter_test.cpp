#include "tests/support/allocation_counter.h"

#include <cstdlib>
#include <memory>
#include <thread>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace palpate::test {
namespace {

/// Keeps the compiler from optimising an allocation away.
template <class T>
void Use(T* p) {
  asm volatile("" : : "g"(p) : "memory");
}

TEST(AllocationCounter, SeesEveryWayToAskForMemoryInItsOwnThreadAlone) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizers bring an allocator of their own";
  struct alignas(64) Line {
    char bytes[64];
  };
  const auto freed = [](void* p) {
    Use(p);
    std::free(p);
  };
  const struct {
    const char* what;
    void (*ask)(decltype(freed));
  } ways[] = {
      {"operator new", [](auto) { Use(std::make_unique<int>(3).get()); }},
      {"operator new of what is aligned", [](auto) { Use(std::make_unique<Line>().get()); }},
      {"a vector of Eigen's of any size",
       [](auto) { Use(Eigen::VectorXd::Ones(9).eval().data()); }},
      {"malloc", [](auto free) { free(std::malloc(8)); }},
      {"realloc", [](auto free) { free(std::realloc(nullptr, 4000)); }},
      {"calloc", [](auto free) { free(std::calloc(3, 8)); }},
      {"aligned_alloc", [](auto free) { free(std::aligned_alloc(64, 128)); }}};
  for (const auto& way : ways) {
    const std::uint64_t before = AllocationsOfThisThread();
    way.ask(freed);
    EXPECT_EQ(AllocationsOfThisThread() - before, 1u) << way.what;
  }

  std::thread other;
  other = std::thread([] {
    const std::uint64_t before = AllocationsOfThisThread();
    for (int i = 0; i < 10; ++i) Use(std::make_unique<int>(i).get());
    EXPECT_EQ(AllocationsOfThisThread() - before, 10u);
  });
  const std::uint64_t before = AllocationsOfThisThread();
  other.join();
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate::test
