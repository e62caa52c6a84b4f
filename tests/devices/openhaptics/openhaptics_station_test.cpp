// End to end: palpate-server, and palpate-station with the driver and a fake of the vendor's
// library.  The library keeps what the arm's motors do in a file that the test reads.
#include <cstdlib>
#include <functional>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include "devices/openhaptics/hd_library.h"
#include "tests/devices/openhaptics/fake_hd.h"
#include "tests/support/eventually.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

const std::string kDomain = std::to_string(OwnDomain());
/// Height of the ball's centre when it rests on the scene's cube.
constexpr double kTop_mm = 30.0;

class OpenHapticsStation : public testing::Test {
 protected:
  OpenHapticsStation() {
    const int fd = open(file_.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
    if (fd < 0 || ftruncate(fd, sizeof(FakeArm)) != 0) std::abort();
    void* memory = mmap(nullptr, sizeof(FakeArm), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (memory == MAP_FAILED) std::abort();
    arm_ = new (memory) FakeArm;
    arm_->hand_mm[1] = arm_->position_mm[1] = kTop_mm + 5.0;
    setenv(kFakeArmVariable, file_.c_str(), 1);
    setenv(hd::kLibraryVariable, PALPATE_FAKE_HD, 1);
  }
  ~OpenHapticsStation() override {
    station_.reset();
    server_.reset();
    munmap(arm_, sizeof(FakeArm));
    unlink(file_.c_str());
  }

  void StartServer() {
    server_ = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-server",
        std::vector<std::string>{"--scene", "cube", "--realtime", "off", "--transport", "udp",
                                 "--domain", kDomain});
    ASSERT_TRUE(server_->Says("ready: ", 60.0)) << server_->Output();
  }
  void StartStation(const std::vector<std::string>& more) {
    station_ = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-station",
        Joined({"--device", "openhaptics", "--scene", "cube", "--id", "arm", "--no-table",
                "--realtime", "off", "--transport", "udp", "--domain", kDomain},
               more));
    ASSERT_TRUE(station_->Says("session: tool", 60.0)) << station_->Output();
  }
  /// Waits, reading both programs' output so that no full pipe stops them.
  bool Eventually(const std::function<bool()>& so, double seconds = 60.0) {
    return test::Eventually(
        [&] {
          if (server_) server_->Output();
          station_->Output();
          return so();
        },
        seconds);
  }
  void For(double seconds) {
    Eventually([] { return false; }, seconds);
  }
  /// The hand presses `depth_mm` deep within a third of a second; the motors hold against it.
  void Press(double depth_mm) {
    const double from = arm_->hand_mm[1], to = kTop_mm - depth_mm;
    for (int i = 1; i <= 100; ++i) {
      arm_->hand_mm[1] = from + 0.01 * i * (to - from);
      For(0.003);
    }
  }
  const std::string file_ = testing::TempDir() + "palpate-fake-arm-" + std::to_string(getpid());
  FakeArm* arm_ = nullptr;
  std::unique_ptr<Program> server_;
  std::unique_ptr<Program> station_;
};

TEST_F(OpenHapticsStation, GivesForcesWithinTheUsersLimitWhileTheButtonIsHeldAndNoLonger) {
  StartServer();
  StartStation({"--max-force", "0.5"});
  Press(1.0);
  For(1.0);
  EXPECT_EQ(arm_->most_force_N, 0.0);
  arm_->buttons = 1;
  ASSERT_TRUE(Eventually([&] { return arm_->force_N > 0.45; })) << station_->Output();
  For(0.5);
  EXPECT_LE(arm_->most_force_N, 0.5) << "of the 0.67 N that the cube gives";
  arm_->buttons = 0;
  EXPECT_TRUE(Eventually([&] { return arm_->force_N == 0.0; }));
  EXPECT_THAT(station_->Output(), HasSubstr("while the first button is held"));
  EXPECT_THAT(station_->Output(),
              HasSubstr("limits: 0.50 N and 0.011 N m, once the motors are warm 0.50 N and 0.011"));
}

}  // namespace
}  // namespace palpate::test
