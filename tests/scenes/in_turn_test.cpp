#include "scenes/in_turn.h"

#include <atomic>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::ElementsAre;
using Numbers = InTurn<int>;

/// Opened once, for whoever waits.
class Gate {
 public:
  void Open() { opened_.set_value(); }
  void Wait() { open_.wait(); }

 private:
  std::promise<void> opened_;
  std::shared_future<void> open_ = opened_.get_future().share();
};

TEST(InTurn, HandsOverWhatWasMadeLastFirstWhereItIsTheFirst) {
  Gate last_made;
  Numbers numbers(3, 3, [&](std::size_t n, const Numbers::Say&) {
    n == 2 ? last_made.Open() : last_made.Wait();
    return static_cast<int>(10 * n);
  });
  EXPECT_EQ(numbers.Take(), 0);
  EXPECT_EQ(numbers.Take(), 10);
  EXPECT_EQ(numbers.Take(), 20);
}

TEST(InTurn, SaysEachThingsWordsInTheTakersThreadAtItsTurn) {
  for (const std::size_t threads : {1u, 4u}) {
    std::vector<std::string> heard;
    const auto taker = std::this_thread::get_id();
    Numbers numbers(3, threads, [&](std::size_t n, const Numbers::Say& say) {
      for (const char* word : {"begun", "done"}) {
        say([&, n, word] {
          EXPECT_EQ(std::this_thread::get_id(), taker);
          heard.push_back(std::to_string(n) + " " + word);
        });
      }
      return 0;
    });
    for (int n = 0; n < 3; ++n) {
      numbers.Take();
      heard.push_back("taken");
    }
    EXPECT_THAT(heard, ElementsAre("0 begun", "0 done", "taken", "1 begun", "1 done", "taken",
                                   "2 begun", "2 done", "taken"));
  }
}

TEST(InTurn, SaysWordsBeforeTheThingIsMade) {
  Gate heard;
  Numbers numbers(1, 1, [&](std::size_t, const Numbers::Say& say) {
    say([&] { heard.Open(); });
    heard.Wait();
    return 7;
  });
  EXPECT_EQ(numbers.Take(), 7);
}

TEST(InTurn, ThrowsTheFirstFailureInTheOrderOfTheThingsNotOfTime) {
  Gate second_failed;
  std::vector<std::string> heard;
  Numbers numbers(3, 3, [&](std::size_t n, const Numbers::Say& say) -> int {
    if (n == 1) {
      say([&] { heard.push_back("1"); });
      second_failed.Open();
      throw std::runtime_error("second");
    }
    second_failed.Wait();
    if (n == 0) throw std::runtime_error("first");
    return 0;
  });
  try {
    numbers.Take();
    FAIL() << "took what was not made";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "first");
  }
  EXPECT_TRUE(heard.empty()) << "of what was not taken";
}

TEST(InTurn, EndsTheMakingOfWhatNobodyTakesAnyMore) {
  Gate begun;
  std::atomic<bool> made = false;
  std::atomic<int> later = 0;
  {
    Numbers numbers(100, 2, [&](std::size_t n, const Numbers::Say& say) -> int {
      if (n == 0) {
        begun.Wait();
        throw std::runtime_error("first");
      }
      if (n > 1) return ++later;
      begun.Open();
      while (!made) say([] {});  // without end, were it not ended
      return 0;
    });
    EXPECT_THROW(numbers.Take(), std::runtime_error);
  }
  EXPECT_EQ(later, 0);
  // Nor where nobody takes anything at all.
  Gate running;
  {
    Numbers numbers(100, 1, [&](std::size_t n, const Numbers::Say& say) -> int {
      if (n == 0) running.Open();
      while (!made) say([] {});
      return 0;
    });
    running.Wait();
  }
}

TEST(InTurn, MakesNoMoreAtOnceThanItHasThreadsNorFarAhead) {
  constexpr std::size_t kThreads = 3;
  std::atomic<int> at_once = 0, most = 0, begun = 0, taken = 0;
  std::atomic<bool> too_far = false;
  Numbers numbers(50, kThreads, [&](std::size_t n, const Numbers::Say&) {
    const int now = ++at_once;
    for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) {
    }
    if (++begun > taken + 1 + static_cast<int>(2 * kThreads)) too_far = true;
    std::this_thread::yield();
    --at_once;
    return static_cast<int>(n);
  });
  for (int n = 0; n < 50; ++n) {
    EXPECT_EQ(numbers.Take(), n);
    ++taken;
  }
  EXPECT_LE(most, static_cast<int>(kThreads));
  EXPECT_FALSE(too_far);
}

}  // namespace
}  // namespace palpate
