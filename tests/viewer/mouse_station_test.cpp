#include "client/viewer/mouse_station.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"
#include "devices/mouse/mouse_device.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/random.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

bool Ends(MouseStation& station, std::int64_t add_ns = 0) {
  return test::Eventually([&] { return !station.Poll(SteadyNanoseconds() + add_ns); });
}

/// Arguments with which a shell stands in for a station.
std::vector<std::string> Script(const std::string& text) {
  return {"-c", text};
}

TEST(MouseStation, IsGivenPosesAsLinesAndTheEndOfItsInput) {
  const test::Folder folder;
  const std::string file = folder / "poses";
  MouseStation station("/bin/sh", Script("cat > " + file));
  station.Drag({Vec3(0.1, 0, 0), Quat::Identity()});
  station.Drag({Vec3(0.2, 0, 0), Quat::Identity()});
  EXPECT_TRUE(station.Poll(0));
  station.LetGo(SteadyNanoseconds());
  station.Drag({Vec3(0.3, 0, 0), Quat::Identity()});  // goes nowhere
  EXPECT_TRUE(Ends(station));
  EXPECT_EQ(station.complaint(), "");
  EXPECT_EQ(ReadWholeFile(file), "0.1 0 0 1 0 0 0\n0.2 0 0 1 0 0 0\n");
}

TEST(MouseStation, IsToldPosesToTheBit) {
  test::Random random(8);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 p = random.InCube(1.0) * (i % 2 == 0 ? 1.0 : 1e-9);
    const Vec3 a = random.InCube(1.0);
    const Pose X{p, Quat(1.0, a.x(), a.y(), a.z())};
    std::string line = ToMouseLine(X, i % 3 == 0);
    ASSERT_EQ(line.back(), '\n');
    line.pop_back();
    std::string complaint;
    const auto read = ParseMouseLine(line, complaint);
    ASSERT_TRUE(read && read->X_WT) << line << complaint;
    ASSERT_EQ(read->X_WT->p, p);
    ASSERT_EQ(read->still, i % 3 == 0);
    ASSERT_LT((read->X_WT->q.coeffs() - X.q.normalized().coeffs()).norm(), 1e-15);
  }
}

TEST(MouseStation, TellsWhatItComplainedOfWhereItFailed) {
  MouseStation failing("/bin/sh", Script("echo one; echo 'sh: the tool is taken' >&2; exit 1"));
  EXPECT_TRUE(Ends(failing));
  EXPECT_EQ(failing.complaint(), "the tool is taken");
  MouseStation missing("/no/such/program", {});
  EXPECT_TRUE(Ends(missing));
  EXPECT_EQ(missing.complaint(), "program could not be run (exit 127)");
}

TEST(MouseStation, PassesOverPosesWhileTheStationDoesNotRead) {
  MouseStation station("/bin/sh", Script("sleep 100"));
  for (int i = 0; i < 100'000; ++i) station.Drag({Vec3(0.1, 0.2, 0.3), Quat::Identity()});
  EXPECT_TRUE(station.Poll(SteadyNanoseconds()));
}

TEST(MouseStation, HasEndedWhereSomebodyElseWaitedForIt) {
  MouseStation station("/bin/sh", Script("exit 0"));
  int status = 0;
  ASSERT_GT(waitpid(-1, &status, 0), 0);
  EXPECT_FALSE(station.Poll(SteadyNanoseconds()));
  EXPECT_FALSE(station.Poll(SteadyNanoseconds()));
  EXPECT_EQ(station.complaint(), "what became of the mouse's station is not known");
}

TEST(MouseStation, IsKilledWhereItDoesNotEnd) {
  MouseStation station("/bin/sh", Script("trap '' TERM; while :; do sleep 0.05; done"));
  station.LetGo(SteadyNanoseconds());
  EXPECT_TRUE(station.Poll(SteadyNanoseconds()));
  EXPECT_TRUE(Ends(station, 4'000'000'000));
  EXPECT_EQ(station.complaint(), "the mouse's station was killed");
}

TEST(MouseStation, InheritsNoFileOfItsParent) {
  const int open_here = dup(STDOUT_FILENO);
  MouseStation station(
      "/bin/sh", Script("test ! -e /proc/self/fd/" + std::to_string(open_here) + " || exit 1"));
  EXPECT_TRUE(Ends(station));
  EXPECT_EQ(station.complaint(), "");
  close(open_here);
}

}  // namespace
}  // namespace palpate
