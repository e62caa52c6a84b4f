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
  for (const int signal : {SIGINT, SIGTERM}) {
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
  EXPECT_EXIT(
      {
        StopSignal stop;
        raise(SIGINT);
        raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace palpate
