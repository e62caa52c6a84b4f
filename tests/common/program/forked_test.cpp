#include "common/program/forked.h"

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <unistd.h>

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Tell = std::function<void(const std::string&)>;

TEST(RunForked, TellsWhatItsWorkTellsAndThatItFinished) {
  int here = 0;
  const ForkedEnd end = RunForked(
      [&](const Tell& tell) {
        here = 1;
        tell("one");
        tell("");
        tell(std::string(100'000, 'x'));
      },
      60.0);
  EXPECT_TRUE(end.finished);
  EXPECT_EQ(end.how, "");
  EXPECT_THAT(end.told, ElementsAre("one", "", std::string(100'000, 'x')));
  EXPECT_EQ(here, 0) << "another process";
}

TEST(RunForked, NamesTheForeignCallOfTheThreadThatCrashes) {
  const auto in_a_thread = [](int signal) {
    return [signal](const Tell& tell) {
      tell("before");
      const ForeignCall outer("outer");
      { const ForeignCall inner("inner"); }
      std::thread([signal] {
        const ForeignCall call("theirs");
        std::raise(signal);
      }).join();
    };
  };
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE}) {
    const ForkedEnd end = RunForked(in_a_thread(signal), 60.0);
    EXPECT_FALSE(end.finished);
    EXPECT_THAT(end.told, ElementsAre("before"));
    EXPECT_THAT(end.how, HasSubstr("theirs crashed")) << signal;
  }
  EXPECT_THAT(RunForked([](const Tell&) { std::abort(); }, 60.0).how, HasSubstr("crashed"));
}

TEST(RunForked, KnowsWorkThatEndsTheProcessOrThrowsFromFinishedWork) {
  EXPECT_FALSE(RunForked([](const Tell&) { _exit(0); }, 60.0).finished);
  EXPECT_FALSE(RunForked([](const Tell&) { throw std::runtime_error("no"); }, 60.0).finished);
}

TEST(RunForked, EndsWorkThatDoesNotReturn) {
  const ForkedEnd end = RunForked([](const Tell&) { pause(); }, 0.05);
  EXPECT_FALSE(end.finished);
  EXPECT_THAT(end.how, HasSubstr("in time"));
}

TEST(RunForked, TellsItsWorkToEndWhereThisProcessIsToldTo) {
  const ForkedEnd end = RunForked([](const Tell&) { pause(); }, 60.0, [] { return true; });
  EXPECT_FALSE(end.finished);
}

}  // namespace
}  // namespace palpate
