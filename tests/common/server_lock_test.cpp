#include "common/server_lock.h"

#include <chrono>
#include <fstream>
#include <future>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/error.h"
#include "common/server_lock_file.h"

namespace palpate {
namespace {

using testing::HasSubstr;

/// No server's, and this process's own.
const int kDomain = 100'000 + 2 * getpid();

class ServerLockTest : public testing::Test {
 protected:
  ~ServerLockTest() override {
    for (const int domain : {kDomain, kDomain + 1}) unlink(ServerLockFile(domain).c_str());
  }
};

std::string Complaint() {
  try {
    const ServerLock lock(kDomain);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_F(ServerLockTest, RefusesASecondServerOfADomainAndNamesTheFirstByItsProgram) {
  const ServerLock first(kDomain);
  std::string program;
  std::getline(std::ifstream("/proc/self/comm"), program);
  EXPECT_THAT(Complaint(), HasSubstr("domain " + std::to_string(kDomain) + " is in use by " +
                                     program + " (pid " + std::to_string(getpid()) + ")"));
  EXPECT_THAT(Complaint(), HasSubstr("--domain"));
  EXPECT_NO_THROW(ServerLock{kDomain + 1});
}

TEST_F(ServerLockTest, SaysWhatItKnowsOfAHolderThatRunsElsewhere) {
  const ServerLock first(kDomain);
  std::ofstream(ServerLockFile(kDomain)) << 0;
  EXPECT_THAT(Complaint(), HasSubstr("is in use by another program (pid 0)"));
}

TEST_F(ServerLockTest, IsFreeOnceItsHolderIsGone) {
  { const ServerLock first(kDomain); }
  EXPECT_NO_THROW(ServerLock{kDomain});
}

TEST_F(ServerLockTest, WaitsForThoseWhoOnlyLookWhetherThereIsAServer) {
  const int look = open(ServerLockFile(kDomain).c_str(), O_RDONLY | O_CREAT, 0644);
  ASSERT_EQ(flock(look, LOCK_SH | LOCK_NB), 0);
  auto complaint = std::async(std::launch::async, Complaint);
  complaint.wait_for(std::chrono::milliseconds(50));  // it has looked several times by then
  close(look);
  EXPECT_EQ(complaint.get(), "");
}

}  // namespace
}  // namespace palpate
