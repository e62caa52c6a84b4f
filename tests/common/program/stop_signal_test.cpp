#include "common/program/stop_signal.h"

#include <csignal>
#include <thread>

#include <gtest/gtest.h>

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
  for (const int signal : {SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM}) {
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
          raise(signal);
        },
        testing::KilledBySignal(signal), "");
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
