#include "server/transport/background_servo.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "tests/support/eventually.h"

namespace palpate::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

wire::HapticPose PoseOf(std::uint64_t sequence) {
  wire::HapticPose pose{};
  pose.pose_sequence = sequence;
  return pose;
}

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(BackgroundServo, AnswersTheNewestPoseAndNoneTwice) {
  std::atomic<std::uint64_t> newest{0}, answered{0};
  BackgroundServo servo([&](const wire::HapticPose& pose) {
    EXPECT_GT(pose.pose_sequence, newest);
    newest = pose.pose_sequence;
    ++answered;
  });
  for (std::uint64_t i = 1; i <= 1000; ++i) servo.Give(PoseOf(i));
  EXPECT_TRUE(Eventually([&] { return newest == 1000; }));
  EXPECT_LE(answered, 1000u);
}

TEST(BackgroundServo, RunsBelowOrdinaryThreads) {
  const int mine = getpriority(PRIO_PROCESS, 0);
  std::atomic<int> its{mine};
  BackgroundServo servo([&](const wire::HapticPose&) {
    its = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  });
  servo.Give(PoseOf(1));
  EXPECT_TRUE(Eventually([&] { return its > mine; }));
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), mine);
}

TEST(BackgroundServo, TakesNoMoreThanItsShareOfACore) {
  std::atomic<int> steps{0};
  const auto began = steady_clock::now();
  {
    BackgroundServo servo([&](const wire::HapticPose&) {
      // By its own time, as other threads hold it up.
      const double end_s = CpuSeconds() + 0.002;
      while (CpuSeconds() < end_s) {
      }
      ++steps;
    });
    for (std::uint64_t i = 1; i <= 1000; ++i) {
      servo.Give(PoseOf(i));
      std::this_thread::sleep_for(milliseconds(1));
    }
  }
  const double seconds = std::chrono::duration<double>(steady_clock::now() - began).count();
  EXPECT_GT(steps, 0);
  // What may be used at once after a rest, its share of the time, and one step beyond it.
  EXPECT_LE(0.002 * (steps - 1), 0.05 + BackgroundServo::kShare * seconds);
}

}  // namespace
}  // namespace palpate::test
