#include "devices/mouse/mouse_device.h"

#include <chrono>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/devices/limiter_support.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

bool Parses(std::string_view line) {
  std::string complaint;
  const bool parses = ParseMouseLine(line, complaint).has_value();
  EXPECT_EQ(parses, complaint.empty()) << line;
  return parses;
}

TEST(MouseLine, IsAPoseWhoseRotationIsMadeUnit) {
  std::string complaint;
  const auto line = ParseMouseLine(" 0.1 -0.25 3e-3\t2 0 0 0\r", complaint);
  ASSERT_TRUE(line && line->X_WT);
  EXPECT_EQ(line->X_WT->p, Vec3(0.1, -0.25, 0.003));
  EXPECT_EQ(line->X_WT->q.w(), 1.0);
  EXPECT_FALSE(line->still);
  EXPECT_TRUE(ParseMouseLine("0 0 0 1 0 0 0 still", complaint)->still);
}

TEST(MouseLine, LetsGo) {
  std::string complaint;
  const auto line = ParseMouseLine("release", complaint);
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->X_WT);
}

TEST(MouseLine, IsNotUsedWhereItIsNoPose) {
  for (const char* line :
       {"", "1 2 3", "0 0 0 1 0 0", "0 0 0 1 0 0 0 0", "a b c d e f g", "0 0 0 1 0 0 0x",
        "nan 0 0 1 0 0 0", "0 nan 0 1 0 0 0", "0 0 nan 1 0 0 0", "inf 0 0 1 0 0 0",
        "0 11 0 1 0 0 0", "0 0 0 0 0 0 0", "0 0 0 nan 0 0 0", "0 0 0 1e300 0 0 0",
        "1e999 0 0 1 0 0 0", "release me", "0,1 0 0 1 0 0 0", "0 0 0 1 0 0 0 still 1",
        "0 0 0 1 0 0 still"}) {
    EXPECT_FALSE(Parses(line)) << line;
  }
}

TEST(MouseLine, GivesFinitePosesOrNoneForAnyBytes) {
  test::Random random(5);
  const std::string_view alphabet = "0123456789+-.eEinfa \t\rrelease";
  int poses = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::string text;
    const bool bytes = random.Below(4) == 0;
    for (int n = static_cast<int>(random.Below(40)); n > 0; --n) {
      text += bytes ? static_cast<char>(random.Below(256))
                    : alphabet[static_cast<std::size_t>(random.Below(alphabet.size()))];
    }
    if (random.Below(2) == 0) text = "1 2 3 4 5 6 " + text;
    std::string complaint;
    const auto line = ParseMouseLine(text, complaint);
    if (!line || !line->X_WT) continue;
    ++poses;
    ASSERT_TRUE(line->X_WT->p.allFinite());
    ASSERT_NEAR(line->X_WT->q.norm(), 1.0, 1e-12);
  }
  EXPECT_GT(poses, 100);
}

class MouseDeviceTest : public testing::Test {
 protected:
  MouseDeviceTest() {
    if (pipe2(ends_, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    device_ = std::make_unique<MouseDevice>(ends_[0], Pose{Vec3(0, 0, 0.1), Quat::Identity()});
  }
  ~MouseDeviceTest() override {
    device_.reset();
    close(ends_[0]);
    CloseInput();
  }
  void Write(const std::string& text) {
    ASSERT_EQ(write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void CloseInput() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  /// Ticks until the condition holds: the lines take a while to come through.
  template <class Condition>
  bool TickUntil(Condition condition) {
    for (int i = 0; i < 20'000; ++i) {
      sample_ = device_->Read();
      if (condition()) return true;
      device_->Apply(PassThrough({}));
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    return false;
  }

  int ends_[2] = {-1, -1};
  std::unique_ptr<MouseDevice> device_;
  DeviceSample sample_;
};

TEST_F(MouseDeviceTest, WaitsWhereItStartsAndThenFollowsTheLines) {
  EXPECT_EQ(device_->Read().X_WH.p, Vec3(0, 0, 0.1));
  EXPECT_STREQ(device_->activity(), "waits for the mouse");
  Write("0.02 0 0.1 1 0 0 0\n");
  EXPECT_TRUE(TickUntil([&] { return (sample_.X_WH.p - Vec3(0.02, 0, 0.1)).norm() < 1e-4; }));
  EXPECT_STREQ(device_->activity(), "follows");
  EXPECT_TRUE(sample_.status & kDeviceForcesIgnored);
}

TEST_F(MouseDeviceTest, PassesOverWhatIsNoLineAndGoesOn) {
  Write("hello\n" + std::string(5000, '1') + "\n0 0 nan 1 0 0 0\n\n0 0 0.2 1 0 0 0\n");
  EXPECT_TRUE(TickUntil([&] { return sample_.X_WH.p.z() > 0.199; }));
}

TEST_F(MouseDeviceTest, LetsGoAtTheGraphicTool) {
  Write("0 0 0 1 0 0 0\n");
  const Pose stopped{Vec3(0, 0, 0.09), Quat::Identity()};
  EXPECT_TRUE(TickUntil([&] {
    device_->SeeGraphicTool(stopped, Vec3::Zero());
    return sample_.X_WH.p.z() < 0.0701;
  }));
  EXPECT_STREQ(device_->activity(), "follows, as far as it may press");
  Write("release\n");
  EXPECT_TRUE(TickUntil([&] { return sample_.X_WH.p.z() > 0.0899; }));
  EXPECT_STREQ(device_->activity(), "let go");
}

TEST_F(MouseDeviceTest, EndsWithItsInputAndTakesTheLastLineToo) {
  Write("0 0 0.2 1 0 0 0");
  EXPECT_FALSE(device_->ended());
  CloseInput();
  EXPECT_TRUE(TickUntil([&] { return device_->ended(); }));
  EXPECT_TRUE(TickUntil([&] { return sample_.X_WH.p.z() > 0.199; }));
}

}  // namespace
}  // namespace palpate
