#include "common/program/stop_signal.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace palpate {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(StopSignal, StaysSilentWithoutASignal) {
  StopSignal stop;
  EXPECT_FALSE(stop.WaitFor(milliseconds(1)));
  EXPECT_FALSE(stop.stopped());
}

TEST(StopSignal, EndsTheWait) {
  for (const int signal : {SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM, SIGXCPU}) {
    StopSignal stop;
    std::thread sender([signal] {
      std::this_thread::sleep_for(milliseconds(20));
      kill(getpid(), signal);
    });
    EXPECT_TRUE(stop.WaitFor(seconds(60))) << signal;
    EXPECT_TRUE(stop.stopped()) << signal;
    sender.join();
  }
}

TEST(StopSignal, LetsASecondSignalKill) {
  for (const int signal : {SIGINT, SIGQUIT, SIGTERM}) {
    EXPECT_EXIT(
        {
          StopSignal stop;
          raise(signal);
          std::this_thread::sleep_for(milliseconds(250));
          raise(signal);
        },
        testing::KilledBySignal(signal), "");
  }
}

TEST(StopSignal, TakesASignalThatItsSenderDoublesForOne) {
  for (const int signal : {SIGINT, SIGQUIT, SIGTERM}) {
    EXPECT_EXIT(
        {
          StopSignal stop;
          raise(signal);
          raise(signal);  // as `timeout` does, and a wrapper beside its terminal
          _exit(stop.stopped() ? 0 : 1);
        },
        testing::ExitedWithCode(0), "");
  }
}

TEST(StopSignal, TakesTheSeveralSignalsOfAClosedTerminalForOne) {
  EXPECT_EXIT(
      {
        StopSignal stop;
        for (int i = 0; i < 3; ++i) raise(SIGHUP);
        for (int i = 0; i < 3; ++i) raise(SIGPIPE);
        _exit(stop.stopped() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(StopSignal, LetsAFileAtItsSizeLimitFailAsAWriteError) {
  EXPECT_EXIT(
      {
        StopSignal stop;
        rlimit none{};
        getrlimit(RLIMIT_FSIZE, &none);
        none.rlim_cur = 0;
        setrlimit(RLIMIT_FSIZE, &none);
        std::FILE* const file = std::tmpfile();
        const bool written = std::fputc('a', file) != EOF && std::fflush(file) == 0;
        _exit(!written && errno == EFBIG && !stop.stopped() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(StopSignal, LeavesAHangUpIgnoredAsNohupWantsIt) {
  for (const int signal : {SIGHUP, SIGPIPE}) {
    EXPECT_EXIT(
        {
          std::signal(signal, SIG_IGN);
          bool stopped = false;
          {
            StopSignal stop;
            raise(signal);
            stopped = stop.stopped();
          }
          raise(signal);  // and it stays ignored
          _exit(stopped ? 1 : 0);
        },
        testing::ExitedWithCode(0), "");
  }
}

TEST(StopSignal, EndsAScriptsBackgroundJobThatShellsStartWithTheInterruptIgnored) {
  for (const int signal : {SIGINT, SIGQUIT}) {
    EXPECT_EXIT(
        {
          std::signal(signal, SIG_IGN);
          StopSignal stop;
          raise(signal);
          _exit(stop.stopped() ? 0 : 1);
        },
        testing::ExitedWithCode(0), "");
  }
}

TEST(StayAwake, RunsOnThroughCtrlZ) {
  EXPECT_EXIT(
      {
        StayAwake();
        for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) raise(signal);
        _exit(0);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace palpate
