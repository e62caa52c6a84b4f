#include "common/dds/shared_memory_watch.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "tests/common/dds/peer.h"
#include "tests/support/roudi.h"

namespace palpate::dds {
namespace {

using std::chrono::milliseconds;
using testing::ExitedWithCode;

constexpr const char* kRemedy = "shared memory hangs \\(a test\\).*restart iox-roudi";

class SharedMemoryWatchDeathTest : public testing::Test {
 protected:
  SharedMemoryWatchDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(SharedMemoryWatchDeathTest, EndsAProcessThatHangsAndSaysWhatToDo) {
  EXPECT_EXIT(
      {
        const SharedMemoryWatch watch("a test", milliseconds(100));
        std::this_thread::sleep_for(std::chrono::hours(1));
      },
      ExitedWithCode(1), kRemedy);
}

/// A watch's patience is twenty looks, so a machine that stands still uses up one of them, not the
/// whole patience.
TEST_F(SharedMemoryWatchDeathTest, LeavesWhatEndsInTimeAlone) {
  EXPECT_EXIT(
      {
        for (int i = 0; i < 100; ++i) const SharedMemoryWatch watch("a test", milliseconds(200));
        std::this_thread::sleep_for(milliseconds(400));
        std::exit(3);
      },
      ExitedWithCode(3), "");
}

TEST(RouDiThatHangs, IsNotWaitedForByWhoComes) {
  RouDi roudi;
  roudi.Hang();
  Peer peer("shm", 88, "late", 1, "at-once");
  EXPECT_EQ(peer.Wait(), 1);
}

TEST(RouDiThatHangs, IsNotWaitedForByWhoLeaves) {
  RouDi roudi;
  Peer peer("shm", 88, "leaving", 10, "in-step");
  ASSERT_TRUE(peer.Next()) << "it has come, and writes";
  roudi.Hang();
  EXPECT_TRUE(peer.Next()) << "what is open goes on";
  EXPECT_EQ(peer.Wait(), 1);
}

}  // namespace
}  // namespace palpate::dds
