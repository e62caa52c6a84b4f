#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

/// Wake-ups that are 5 us late and sometimes later.
Finding Check(int wake_ups, std::initializer_list<std::int64_t> late_us, std::uint64_t missed = 0) {
  Jitter jitter{.lateness = {}, .missed = missed};
  for (int i = 0; i < wake_ups; ++i) jitter.lateness.Add(5'000);
  for (const std::int64_t us : late_us) jitter.lateness.Add(1000 * us);
  return CheckJitter(jitter);
}

TEST(Jitter, IsJudgedByWhatIsGoneOfAMillisecondOnceASecondAndByTheWorst) {
  EXPECT_THAT(Check(998, {60, 60}), IsOk());
  EXPECT_THAT(Check(998, {250, 250}), IsWarning());
  EXPECT_THAT(Check(998, {700, 700}), IsFault());
  EXPECT_THAT(Check(10'000, {}), IsOk());
  EXPECT_THAT(Check(10'000, {1500}, 1), IsWarning("1 ms were missed"));
}

TEST(Jitter, IsMeasuredOfEachMillisecondWokenUpForOrMissed) {
  StopSignal stop;
  const Jitter jitter = MeasureJitter(0.3, {}, stop);
  // Each of the 300 was either woken up for or missed; the last may come after the end.
  EXPECT_NEAR(static_cast<double>(jitter.lateness.count() + jitter.missed), 299.0,
              2.0 + static_cast<double>(jitter.missed));
}

TEST(Ports, AreAServersWhereItHasItsOwn) {
  const MadeUpHost host;
  const auto hold = [&](const std::string& hexadecimal) {
    host.Write("/proc/net/udp", "  sl  local_address rem_address\n  12: 0100007F:" + hexadecimal +
                                    " 00000000:0000 07\n");
    return ServerRuns(host.files, 0);
  };
  EXPECT_FALSE(ServerRuns(host.files, 0));
  EXPECT_FALSE(hold("1CF2")) << "a station's, 7410";
  EXPECT_TRUE(hold("1D54")) << "7508";
}

using dds::Transport;

constexpr const char* kPools = "/usr/share/palpate/roudi.toml";
constexpr long long kUser = 1000;

/// What a host shows of RouDi.
class MadeUpRouDi : public testing::Test {
 protected:
  MadeUpRouDi() { host.Write("/tmp/x", ""); }
  ~MadeUpRouDi() override {
    if (socket_ >= 0) close(socket_);
    if (lock_ >= 0) close(lock_);
  }
  void Listen() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, host.files.At("/tmp/roudi").c_str());
    socket_ = socket(AF_UNIX, SOCK_DGRAM, 0);
    ASSERT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  void Die() {
    close(socket_);
    socket_ = -1;
  }
  void HoldLock() {
    host.Write("/tmp/iox-unique-roudi.lock", "");
    lock_ = open(host.files.At("/tmp/iox-unique-roudi.lock").c_str(), O_RDWR);
    ASSERT_EQ(flock(lock_, LOCK_EX), 0);
  }
  void CommandLine(const std::string& words) const {
    host.Write("/proc/321/comm", "iox-roudi\n");
    host.Write("/proc/321/cmdline", words);
    host.Write("/proc/9/comm", "sshd\n");
  }
  Finding Check(Transport wanted) const {
    return CheckRouDi(LookAtRouDi(host.files), wanted, getuid(), kPools);
  }
  MadeUpHost host;

 private:
  int socket_ = -1, lock_ = -1;
};

TEST_F(MadeUpRouDi, ThatAnswersAndHoldsItsLockIsFineUnlessItsPoolsAreItsOwn) {
  Listen();
  HoldLock();
  CommandLine(std::string("iox-roudi\0-c\0/etc/palpate/roudi.toml\0", 38));
  EXPECT_THAT(Check(Transport::kAuto), IsOk("answers, with the pools of /etc/palpate/roudi.toml"));
  CommandLine(std::string("iox-roudi\0", 10));
  EXPECT_THAT(Check(Transport::kAuto), IsWarning("started without -c"));
}

TEST_F(MadeUpRouDi, ThatDoesNotRunIsAWarningAFaultOrNothingByWhatIsWanted) {
  EXPECT_THAT(Check(Transport::kAuto), IsWarning("", std::string("iox-roudi -c ") + kPools));
  EXPECT_THAT(Check(Transport::kSharedMemory), IsFault());
  EXPECT_THAT(Check(Transport::kUdp), IsOk());
}

TEST_F(MadeUpRouDi, ThatHoldsNoLockIsNoneAndLeavesItsSocketWhereItWasKilled) {
  Listen();
  EXPECT_THAT(Check(Transport::kAuto), IsFault("a program other than RouDi", "ss -xlp"));
  Die();
  EXPECT_THAT(Check(Transport::kAuto), IsWarning("a killed one left its socket"));
}

TEST_F(MadeUpRouDi, WhoseSocketIsInAnotherTmpIsAFault) {
  HoldLock();
  EXPECT_THAT(Check(Transport::kAuto), IsFault("", "PrivateTmp=no"));
}

TEST_F(MadeUpRouDi, OfAnotherUserWhoseLockIsClosedIsFineWhereItAnswers) {
  Listen();
  HoldLock();
  host.files.may_open = [](const std::string& path) { return !path.ends_with(".lock"); };
  EXPECT_THAT(Check(Transport::kSharedMemory), IsOk());
}

TEST_F(MadeUpRouDi, OfAnotherUserThatHasLeftItsLockIsToldHowToRemoveIt) {
  host.Write("/tmp/iox-unique-roudi.lock", "");
  host.files.may_open = [](const std::string&) { return false; };
  EXPECT_THAT(Check(Transport::kSharedMemory), IsFault("", "sudo rm /tmp/iox-unique-roudi.lock"));
  EXPECT_THAT(Check(Transport::kUdp), IsOk());
}

TEST(RouDi, OfAnotherUserIsToldWithTheGroup) {
  const RouDiState roudi{.socket = true, .lock_held = true, .owner = 998};
  EXPECT_THAT(CheckRouDi(roudi, Transport::kAuto, kUser, kPools),
              IsWarning("id 998", "adduser $USER palpate"));
  EXPECT_THAT(CheckRouDi(roudi, Transport::kSharedMemory, kUser, kPools), IsFault());
}

TEST(SharedMemory, IsLookedForWhereItIs) {
  const MadeUpHost host;
  EXPECT_FALSE(SpaceIn(host.files, "/dev/shm"));
  EXPECT_TRUE(SpaceIn(host.files, ""));
}

}  // namespace
}  // namespace palpate::doctor
