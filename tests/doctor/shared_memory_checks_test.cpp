#include "client/doctor/shared_memory_checks.h"

#include <cstring>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using dds::Transport;
using testing::HasSubstr;
using testing::Not;

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

TEST_F(MadeUpRouDi, ThatAnswersAndHoldsItsLockIsFine) {
  Listen();
  HoldLock();
  CommandLine(std::string("iox-roudi\0-c\0/etc/palpate/roudi.toml\0", 38));
  const Finding finding = Check(Transport::kAuto);
  EXPECT_EQ(finding.status, Status::kOk) << finding.found;
  EXPECT_EQ(finding.found, "answers, with the pools of /etc/palpate/roudi.toml");
}

TEST_F(MadeUpRouDi, WithPoolsOfItsOwnIsAWarning) {
  Listen();
  HoldLock();
  CommandLine(std::string("iox-roudi\0", 10));
  const Finding finding = Check(Transport::kAuto);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("started without -c"));
}

TEST_F(MadeUpRouDi, ThatDoesNotRunIsAWarningAFaultOrNothingByWhatIsWanted) {
  EXPECT_EQ(Check(Transport::kAuto).status, Status::kWarning);
  EXPECT_EQ(Check(Transport::kSharedMemory).status, Status::kFault);
  EXPECT_EQ(Check(Transport::kUdp).status, Status::kOk);
  EXPECT_THAT(Check(Transport::kAuto).remedy, HasSubstr(std::string("iox-roudi -c ") + kPools));
}

TEST_F(MadeUpRouDi, ThatWasKilledIsToldByTheSocketThatItLeft) {
  Listen();
  Die();
  const Finding finding = Check(Transport::kAuto);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("a killed one has left its socket"));
}

TEST_F(MadeUpRouDi, ThatHoldsNoLockIsNone) {
  Listen();
  const Finding finding = Check(Transport::kAuto);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.found, HasSubstr("something that is no RouDi"));
  EXPECT_THAT(finding.remedy, HasSubstr("ss -xlp"));
}

TEST_F(MadeUpRouDi, WhoseSocketIsInAnotherTmpIsAFault) {
  HoldLock();
  const Finding finding = Check(Transport::kAuto);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.remedy, HasSubstr("PrivateTmp=no"));
}

TEST_F(MadeUpRouDi, OfAnotherUserWhoseLockIsClosedIsFineWhereItAnswers) {
  Listen();
  HoldLock();
  host.files.may_open = [](const std::string& path) { return !path.ends_with(".lock"); };
  EXPECT_EQ(Check(Transport::kSharedMemory).status, Status::kOk);
}

TEST_F(MadeUpRouDi, OfAnotherUserThatHasLeftItsLockIsToldHowToRemoveIt) {
  host.Write("/tmp/iox-unique-roudi.lock", "");
  host.files.may_open = [](const std::string&) { return false; };
  const Finding finding = Check(Transport::kSharedMemory);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.remedy, HasSubstr("sudo rm /tmp/iox-unique-roudi.lock"));
  EXPECT_EQ(Check(Transport::kUdp).status, Status::kOk);
}

TEST(RouDi, OfAnotherUserIsToldWithTheGroup) {
  const RouDiState roudi{.socket = true, .lock_held = true, .owner = 998};
  const Finding finding = CheckRouDi(roudi, Transport::kAuto, kUser, kPools);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("id 998"));
  EXPECT_THAT(finding.remedy, HasSubstr("adduser $USER palpate"));
  EXPECT_EQ(CheckRouDi(roudi, Transport::kSharedMemory, kUser, kPools).status, Status::kFault);
}

TEST(SharedMemory, MustHoldRouDisPoolsUnlessItHasThemAlready) {
  const Space container{.size_MB = 64, .free_MB = 64};
  const Finding small = CheckSharedMemory(container, false, Transport::kSharedMemory);
  EXPECT_EQ(small.status, Status::kFault);
  EXPECT_THAT(small.found, HasSubstr("64 of 64 MB free: RouDi needs 117 MB"));
  EXPECT_THAT(small.remedy, HasSubstr("--shm-size 256m"));
  EXPECT_EQ(CheckSharedMemory(container, false, Transport::kAuto).status, Status::kWarning);
  EXPECT_EQ(CheckSharedMemory(container, true, Transport::kAuto).status, Status::kOk);
  EXPECT_EQ(CheckSharedMemory(container, false, Transport::kUdp).status, Status::kOk);
  const Finding full = CheckSharedMemory(Space{8000, 3}, false, Transport::kSharedMemory);
  EXPECT_EQ(full.status, Status::kFault);
  EXPECT_THAT(full.remedy, HasSubstr("ls -l /dev/shm"));
  EXPECT_EQ(CheckSharedMemory(Space{8000, 7000}, false, Transport::kAuto).status, Status::kOk);
}

TEST(SharedMemory, ThatIsNotThereIsAFault) {
  MadeUpHost host;
  EXPECT_FALSE(SpaceIn(host.files, "/dev/shm"));
  EXPECT_TRUE(SpaceIn(host.files, ""));
  EXPECT_EQ(CheckSharedMemory(std::nullopt, false, Transport::kAuto).status, Status::kFault);
}

}  // namespace
}  // namespace palpate::doctor
