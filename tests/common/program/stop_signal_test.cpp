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

class StopSignalBy : public testing::TestWithParam<int> {};

TEST_P(StopSignalBy, EndsTheWait) {
  StopSignal stop;
  std::thread sender([] {
    std::this_thread::sleep_for(milliseconds(20));
    kill(getpid(), GetParam());
  });
  EXPECT_TRUE(stop.WaitFor(seconds(60)));
  EXPECT_TRUE(stop.stopped());
  sender.join();
}

INSTANTIATE_TEST_SUITE_P(Signals, StopSignalBy, testing::Values(SIGINT, SIGTERM));

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
