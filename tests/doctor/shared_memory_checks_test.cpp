#include "client/doctor/shared_memory_checks.h"

#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using dds::Transport;

constexpr const char* kPools = "/usr/share/palpate/roudi.toml";
constexpr long long kUser = 1000;

/// RouDi, as far as a host shows it.
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
  EXPECT_THAT(Check(Transport::kAuto), IsFault("something that is no RouDi", "ss -xlp"));
  Die();
  EXPECT_THAT(Check(Transport::kAuto), IsWarning("a killed one has left its socket"));
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

TEST(SharedMemory, MustHoldRouDisPoolsUnlessItHasThemAlready) {
  const Space container{.size_MB = 64, .free_MB = 64};
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kSharedMemory),
              IsFault("64 of 64 MB free: RouDi needs 117 MB", "--shm-size 256m"));
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kAuto), IsWarning());
  EXPECT_THAT(CheckSharedMemory(container, true, Transport::kAuto), IsOk());
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kUdp), IsOk());
  EXPECT_THAT(CheckSharedMemory(Space{8000, 3}, false, Transport::kSharedMemory),
              IsFault("", "ls -l /dev/shm"));
  EXPECT_THAT(CheckSharedMemory(Space{8000, 7000}, false, Transport::kAuto), IsOk());
}

TEST(SharedMemory, ThatIsNotThereIsAFault) {
  MadeUpHost host;
  EXPECT_FALSE(SpaceIn(host.files, "/dev/shm"));
  EXPECT_TRUE(SpaceIn(host.files, ""));
  EXPECT_THAT(CheckSharedMemory(std::nullopt, false, Transport::kAuto), IsFault());
}

}  // namespace
}  // namespace palpate::doctor
