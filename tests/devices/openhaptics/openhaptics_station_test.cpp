// End to end: palpate-server, and palpate-station with the driver and a fake of the vendor's
// library.  The library keeps what the arm's motors do in a file that the test reads.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"
#include "devices/openhaptics/hd_library.h"
#include "tests/devices/openhaptics/fake_hd.h"
#include "tests/link/silence.h"
#include "tests/support/eventually.h"
#include "tests/support/program.h"
#include "tests/support/stall_witness.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

const std::string kDomain = std::to_string(OwnDomain());
/// A touch cannot have been spoilt unless the machine stalled for longer than the age stage passes
/// a reply unchanged.
constexpr double kStallThatIsFelt_ms = 1e3 * AgeStage::kSilenceWhole_s;
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
    unlink(trace_.c_str());
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
                "--realtime", "off", "--transport", "udp", "--domain", kDomain, "--trace", trace_},
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
  /// Presses until `so`.  Presses again only if the machine stalled and the limiter says that it
  /// holds back: where replies were late while the hand pressed, the energy stage has seen less
  /// work than the contact stores, and gives back only what it has seen; or where the station was
  /// held up for so long that the arm let go meanwhile.
  testing::AssertionResult PressUntil(double depth_mm, const std::function<bool()>& so) {
    return Shown(
        [&](StallWitness& witness) {
          witness.Watch(server_->id());
          witness.Watch(station_->id());
          // Where the arm was not in order meanwhile, the button counts once it is seen released.
          const std::uint32_t buttons = arm_->buttons.exchange(0);
          For(0.1);
          arm_->buttons = buttons;
          const std::size_t said = station_->Output().size();
          Press(depth_mm);
          const auto is_spoilt = [&] {
            return ReadTrace(trace_).back().Limited("energy") ||
                   station_->Output().find("the arm is ready", said) != std::string::npos;
          };
          if (Eventually(so, 2.0) || (!is_spoilt() && Eventually(so))) return Attempt::kShown;
          const bool spoilt = is_spoilt();
          Press(-5.0);
          return spoilt ? Attempt::kSpoilt : Attempt::kFailed;
        },
        kStallThatIsFelt_ms);
  }
  /// In the station's trace no tick after `time_ns` has force once no reply has come for as long as
  /// the limiter allows.
  void ExpectGoneAfter(std::int64_t time_ns) const {
    const std::vector<TraceRow> rows = ReadTrace(trace_);
    const std::vector<double> silence_ms = CountedSilence_ms(rows);
    std::size_t silent = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].time_ns < time_ns || silence_ms[i] < kForceGone_ms) continue;
      ++silent;
      ASSERT_TRUE(rows[i].applied.force.isZero(0.0) && rows[i].applied.torque.isZero(0.0))
          << rows[i].tick << ", after " << silence_ms[i] << " ms";
    }
    EXPECT_GT(silent, 100u);
  }

  const std::string file_ = testing::TempDir() + "palpate-fake-arm-" + std::to_string(getpid());
  const std::string trace_ = file_ + ".csv";
  FakeArm* arm_ = nullptr;
  std::unique_ptr<Program> server_;
  std::unique_ptr<Program> station_;
};

TEST_F(OpenHapticsStation, FeelsTheCubeAndLosesTheForceWithItsServer) {
  StartServer();
  StartStation({"--enable-forces"});
  For(0.3);
  EXPECT_EQ(arm_->most_force_N, 0.0) << "in the air";
  // A hand of 2 N/mm against a coupling of 1 N/mm gives two thirds of a newton and of a millimetre.
  ASSERT_TRUE(PressUntil(1.0,
                         [&] {
                           return std::abs(arm_->force_N - 2.0 / 3.0) < 0.01 &&
                                  std::abs(kTop_mm - arm_->position_mm[1] - 2.0 / 3.0) < 0.01;
                         }))
      << arm_->force_N << station_->Output();
  if (IsSkipped()) return;

  const std::int64_t killed_ns = SteadyNanoseconds();
  server_->Signal(SIGKILL);
  EXPECT_EQ(server_->Exit(), -SIGKILL);
  server_.reset();
  const std::uint64_t ticks = arm_->ticks;
  For(1.0);
  EXPECT_EQ(arm_->force_N, 0.0);
  ExpectGoneAfter(killed_ns);
  EXPECT_GT(arm_->ticks, ticks) << "the arm ticks on";

  StartServer();
  EXPECT_TRUE(Eventually([&] { return arm_->force_N > 0.6; })) << station_->Output();
  station_->Signal(SIGINT);
  EXPECT_EQ(station_->Exit(), 0) << station_->Output();
  EXPECT_EQ(arm_->force_N, 0.0) << "it leaves no force behind";
  EXPECT_THAT(station_->Output(), HasSubstr("Fake arm (serial 0042"));
  EXPECT_THAT(station_->Output(), HasSubstr("limits: 8.50 N and 0.188 N m, once the motors are "
                                            "warm 1.40 N and 0.048 N m"));
  EXPECT_THAT(station_->Output(), HasSubstr("the arm is ready"));
}

TEST_F(OpenHapticsStation, GivesForcesWithinTheUsersLimitWhileTheButtonIsHeldAndNoLonger) {
  StartServer();
  StartStation({"--max-force", "0.5"});
  Press(1.0);
  For(1.0);
  EXPECT_EQ(arm_->most_force_N, 0.0);
  arm_->buttons = 1;
  ASSERT_TRUE(PressUntil(1.0, [&] { return arm_->force_N > 0.45; })) << station_->Output();
  if (IsSkipped()) return;
  For(0.5);
  EXPECT_LE(arm_->most_force_N, 0.5) << "of the 0.67 N that the cube gives";
  arm_->buttons = 0;
  EXPECT_TRUE(Eventually([&] { return arm_->force_N == 0.0; }));
  EXPECT_THAT(station_->Output(), HasSubstr("while the first button is held"));
  EXPECT_THAT(station_->Output(),
              HasSubstr("limits: 0.50 N and 0.011 N m, once the motors are warm 0.50 N and 0.011"));
}

TEST_F(OpenHapticsStation, EndsWithOneAndTheReasonWhereTheArmDoesNotOpen) {
  StartServer();
  station_ = std::make_unique<Program>(
      PALPATE_BIN_DIR "/palpate-station",
      std::vector<std::string>{"--device", "openhaptics", "--scene", "cube", "--id", "arm",
                               "--transport", "udp", "--device-name", "left", "--domain", kDomain});
  EXPECT_EQ(station_->Exit(), 1);
  EXPECT_THAT(station_->Output(), HasSubstr("tried left"));
}

}  // namespace
}  // namespace palpate::test
