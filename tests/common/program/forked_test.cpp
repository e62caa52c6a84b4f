#include "common/program/forked.h"

#include <chrono>
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
  EXPECT_THAT(end.lines, ElementsAre("one", "", std::string(100'000, 'x')));
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
    EXPECT_THAT(end.lines, ElementsAre("before"));
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

TEST(RunForked, EndsItsWorkByTheSignalThatEndsTheProgram) {
  const StopSignal stop;
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const auto work = [&](const Tell&) {
    (void)!write(ends[1], "!", 1);
    pause();  // which the work's copy of the handler interrupts, long before its time
  };
  const auto stopped = [&] {
    char byte = 0;
    const bool works = read(ends[0], &byte, 1) == 1;
    usleep(200'000);  // from there to the pause
    return works;
  };
  EXPECT_TRUE(RunForked(work, 60.0, stopped).finished);
  close(ends[0]);
  close(ends[1]);
}

TEST(RunForked, LeavesNothingThatItsWorkHasStarted) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_TRUE(RunForked(
                  [](const Tell&) {
                    if (fork() == 0) sleep(20);  // holds the pipe open, as it would the output
                  },
                  60.0)
                  .finished);
  close(ends[1]);
  char byte = 0;
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(read(ends[0], &byte, 1), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(10));
  close(ends[0]);
}

}  // namespace
}  // namespace palpate
