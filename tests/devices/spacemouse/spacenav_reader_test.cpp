#include "devices/spacemouse/spacenav_reader.h"

#include <cstdlib>
#include <filesystem>
#include <functional>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/devices/spacemouse/fake_spacenavd.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using test::FakeSpacenavd;
using testing::HasSubstr;
using Link = SpacenavState::Link;

/// A reader connected to a daemon, and the last state that it read.
struct OpenReader : testing::Test {
  /// Reads until `is_so`; waits long, as a daemon and threads are behind it.
  bool Until(const std::function<bool(const SpacenavState&)>& is_so) {
    return test::Eventually([&] {
      reader.Read(state);
      return is_so(state);
    });
  }
  explicit OpenReader(FakeSpacenavd::Options options = {}) : daemon(options) {}

  FakeSpacenavd daemon;
  SpacenavReader reader;
  SpacenavState state;
};
struct OldDaemon : OpenReader {
  OldDaemon() : OpenReader({.protocol = 0}) {}
};
struct HastyDaemon : OpenReader {
  HastyDaemon() : OpenReader({.early_frames = 3}) {}
};

std::string Complaint() {
  return test::ComplaintOf([] { SpacenavReader reader; });
}

TEST_F(OpenReader, GivesTheAxesAndButtonsOfProtocolOne) {
  EXPECT_EQ(reader.device_name(), "Fake Navigator");
  daemon.Push({1, -2, 3, -4, 5, -6});
  ASSERT_TRUE(Until([](const auto& s) { return s.axes[0] == 1; }));
  EXPECT_EQ(state.axes, (std::array<int, 6>{1, -2, 3, -4, 5, -6}));
  daemon.Press(0, true);
  daemon.Press(3, true);
  ASSERT_TRUE(Until([](const auto& s) { return s.buttons == 0b1001; }));
  daemon.Press(0, false);
  ASSERT_TRUE(Until([](const auto& s) { return s.buttons == 0b1000; }));
  EXPECT_EQ(state.axes[0], 1);  // a button event says nothing about the cap
}

TEST_F(OldDaemon, IsSpokenToInProtocolZero) {
  EXPECT_THAT(reader.device_name(), HasSubstr("older than 1.0"));
  daemon.Push({350, 0, 0, 0, 0, -350});
  daemon.Press(1, true);
  ASSERT_TRUE(Until([](const auto& s) { return s.buttons == 2; }));
  EXPECT_EQ(state.axes, (std::array<int, 6>{350, 0, 0, 0, 0, -350}));
}

TEST_F(HastyDaemon, DoesNotConfuseByAnEventThatIsFasterThanTheAnswer) {
  EXPECT_EQ(reader.device_name(), "Fake Navigator");
  daemon.Push({7, 8, 9, 10, 11, 12});
  ASSERT_TRUE(Until([](const auto& s) { return s.axes[0] != 0; }));
  EXPECT_EQ(state.axes, (std::array<int, 6>{7, 8, 9, 10, 11, 12}));
}

TEST_F(OpenReader, PassesOverFramesAndButtonsThatItDoesNotKnow) {
  for (int i = 0; i < 5; ++i) daemon.Send({99, 1, 2, 3, 4, 5, 6, 7});
  daemon.Send({-1, 1, 2, 3, 4, 5, 6, 7});
  daemon.Press(32, true);
  daemon.Press(-1, true);
  daemon.Push({5, 0, 0, 0, 0, 0});
  ASSERT_TRUE(Until([](const auto& s) { return s.axes[0] == 5; }));
  EXPECT_EQ(state.buttons, 0u);
}

TEST_F(OpenReader, WaitsForTheRestOfAFrame) {
  daemon.SendInPieces({0, 11, 12, 13, 14, 15, 16, 16});
  daemon.Press(2, true);
  ASSERT_TRUE(Until([](const auto& s) { return s.buttons == 4; }));
  EXPECT_EQ(state.axes, (std::array<int, 6>{11, 12, 13, 14, 15, 16}));
  daemon.SendHalf({0, 99, 99, 99, 99, 99, 99, 16});
  daemon.Kill();
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kNoDaemon; }));
  EXPECT_EQ(state.axes[0], 0);
}

TEST_F(OpenReader, RestsWhileTheDaemonIsGoneAndGoesOnWhenItIsBack) {
  for (int round = 0; round < 3; ++round) {
    daemon.Push({300, 0, 0, 0, 0, 0});
    daemon.Press(0, true);
    ASSERT_TRUE(Until([](const auto& s) { return s.buttons == 1; })) << round;
    daemon.Kill();
    ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kNoDaemon; }));
    EXPECT_EQ(state.axes[0], 0);
    EXPECT_EQ(state.buttons, 0u);
    daemon.Start();
    ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kUp; }));
    EXPECT_EQ(state.axes[0], 0);
  }
}

TEST_F(OpenReader, RestsWhileTheDeviceIsUnplugged) {
  daemon.Push({300, 0, 0, 0, 0, 0});
  ASSERT_TRUE(Until([](const auto& s) { return s.axes[0] == 300; }));
  daemon.Unplug();
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kNoDevice; }));
  EXPECT_EQ(state.axes[0], 0);
  daemon.PlugIn();
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kUp; }));
}

TEST_F(OpenReader, SaysWhenTheDaemonComesBackWithoutItsDevice) {
  daemon.Kill();
  daemon.Start({.has_device = false});
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kNoDevice; }));
}

TEST_F(OpenReader, TakesADaemonThatTalksNonsenseForOneThatHasGone) {
  daemon.SendOften({12345, 1, 2, 3, 4, 5, 6, 7}, 20);
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kNoDaemon; }));
  ASSERT_TRUE(Until([](const auto& s) { return s.link == Link::kUp; }));
}

TEST(SpacenavReader, ExplainsWhyItCannotBeOpened) {
  {
    FakeSpacenavd daemon({.has_device = false});
    EXPECT_THAT(Complaint(), HasSubstr("spacenavd runs but has no device; plug"));
  }
  FakeSpacenavd daemon;
  {
    SpacenavReader reader;
    EXPECT_THAT(Complaint(), HasSubstr("has already opened it"));
  }
  daemon.Kill();
  EXPECT_THAT(Complaint(), HasSubstr(daemon.path() + " (Connection refused)"));
  EXPECT_THAT(Complaint(), HasSubstr("start it again"));
  std::filesystem::remove(daemon.path());
  EXPECT_THAT(Complaint(), HasSubstr("spacenavd does not run; install it"));
  setenv("SPNAV_SOCKET", std::string(200, 'x').c_str(), 1);
  EXPECT_THAT(Complaint(), HasSubstr("File name too long"));
}

TEST(SpacenavReader, SaysWhereTheRightsAreMissing) {
  FakeSpacenavd daemon;
  daemon.Kill();  // the socket stays, and no thread: what follows forks
  chmod(daemon.path().c_str(), 0);
  if (geteuid() != 0) {
    EXPECT_THAT(Complaint(), HasSubstr("no permission for spacenavd's socket"));
    return;
  }
  // Root may use any socket, so this runs in a child without root's rights.
  EXPECT_EXIT(
      {
        if (setuid(65534) != 0) std::exit(2);
        std::fputs(Complaint().c_str(), stderr);
        std::exit(0);
      },
      testing::ExitedWithCode(0), "no permission for spacenavd's socket");
}

}  // namespace
}  // namespace palpate
