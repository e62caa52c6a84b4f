#include "common/dds/server_lock.h"

#include <csignal>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/common/dds/own_topic.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using dds::kDomain;
using testing::HasSubstr;

std::string Complaint() {
  return test::ComplaintOf([] { const ServerLock lock(kDomain); });
}

std::string ServerHere() {
  for (const auto& [domain, holder] : ServersOnThisHost(kDomain)) {
    if (domain == kDomain) return holder;
  }
  return "";
}

TEST(ServerLock, RefusesASecondServerOfADomainAndNamesTheFirstByItsProgram) {
  const ServerLock first(kDomain);
  std::string program;
  std::getline(std::ifstream("/proc/self/comm"), program);
  const std::string us = program + " (pid " + std::to_string(getpid()) + ")";
  EXPECT_THAT(Complaint(), HasSubstr("domain " + std::to_string(kDomain) + " is in use by " + us));
  EXPECT_THAT(Complaint(), HasSubstr("--domain"));
  EXPECT_EQ(ServerHere(), us);
  EXPECT_NO_THROW(ServerLock{test::OwnDomain()});
}

TEST(ServerLock, IsFreeOnceItsHolderIsGone) {
  { const ServerLock first(kDomain); }
  EXPECT_EQ(ServerHere(), "");
  EXPECT_NO_THROW(ServerLock{kDomain});
}

/// Another user's process, which holds UDP ports of this host while the object lives.
class Stranger {
 public:
  explicit Stranger(const std::vector<int>& ports) {
    int ready[2];
    if (pipe(ready) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (setuid(kNobody) != 0) _exit(1);
      for (const int port : ports) {
        sockaddr_in place{};
        place.sin_family = AF_INET;
        place.sin_port = htons(static_cast<std::uint16_t>(port));
        const int fd = socket(AF_INET, SOCK_DGRAM, 0);
        if (bind(fd, reinterpret_cast<sockaddr*>(&place), sizeof place) != 0) _exit(1);
      }
      if (write(ready[1], "", 1) != 1) _exit(1);
      pause();
    }
    close(ready[1]);
    char is_ready;
    holds_ = read(ready[0], &is_ready, 1) == 1;
    close(ready[0]);
  }
  ~Stranger() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  bool holds() const { return holds_; }

 private:
  static constexpr uid_t kNobody = 65534;
  pid_t process_ = -1;
  bool holds_ = false;
};

TEST(ServerLock, IsNotKeptFromAServerByAStrangerWhoServesNobody) {
  if (geteuid() != 0) GTEST_SKIP() << "root alone can be another user";
  const Stranger stranger({ServerPort(kDomain)});
  ASSERT_TRUE(stranger.holds());
  EXPECT_EQ(Complaint(), "no complaint");
  EXPECT_EQ(ServerHere(), "");
}

TEST(ServerLock, IsKeptByAnotherUsersServer) {
  if (geteuid() != 0) GTEST_SKIP() << "root alone can be another user";
  const Stranger stranger(
      {ServerPort(kDomain), dds::PortsOf(dds::ServiceDomainId(kDomain)).first + 10});
  ASSERT_TRUE(stranger.holds());
  EXPECT_THAT(Complaint(), HasSubstr(" is in use by "));
  EXPECT_NE(ServerHere(), "");
}

}  // namespace
}  // namespace palpate
