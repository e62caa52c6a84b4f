#include "client/load/process_use.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/dds/server_lock.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

TEST(ProcessUse, ReadsNameAndTimesWhateverTheNameIs) {
  const auto line =
      ParseStatLine("7 (a ) (b) S 1 7 7 0 -1 4194560 1 2 3 4 250 50 9 9 20 0 3 0 100 1 1");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->name, "a ) (b");
  EXPECT_EQ(line->ticks, 300u);
  EXPECT_FALSE(ParseStatLine(""));
  EXPECT_FALSE(ParseStatLine("7 (a) S 1"));
}

TEST(ProcessUse, IsTheTimeUsedByTheTimePassed) {
  ProcessTimes begin;
  begin.time_ns = 1'000'000'000;
  begin.cpu_s = 10.0;
  begin.threads = {{1, {"main", 4.0}}, {2, {"loop", 6.0}}};
  ProcessTimes end;
  end.time_ns = 3'000'000'000;
  end.cpu_s = 13.0;
  end.threads = {{1, {"main", 4.5}}, {2, {"loop", 7.5}}, {3, {"new", 1.0}}};
  const ProcessUse use = UseBetween(begin, end);
  EXPECT_DOUBLE_EQ(use.cpu, 1.5);
  EXPECT_DOUBLE_EQ(use.busiest_thread, 0.75);
  EXPECT_EQ(use.busiest_name, "loop");
  EXPECT_EQ(UseBetween(begin, begin).cpu, 0.0);
}

TEST(ProcessUse, SeesWhatThisProcessUses) {
  const auto begin = TimesOf(getpid());
  ASSERT_TRUE(begin);
  // Until this thread has used a fifth of a second, by the processor's own count.
  timespec used{};
  do {
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  } while (static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec) <
           begin->cpu_s + 0.2);
  const auto end = TimesOf(getpid());
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->cpu_s - begin->cpu_s, 0.2, 0.1);
  EXPECT_FALSE(TimesOf(0));
}

TEST(ProcessUse, SharesTheMachinesTimeIntoBusyAndIdle) {
  const MachineTimes begin = ParseMachineTimes("cpu  100 0 50 800 50 0 0 0 40 0\ncpu0 1 2 3\n");
  EXPECT_EQ(begin.busy, 150u);
  EXPECT_EQ(begin.all, 1000u);
  const MachineTimes end = ParseMachineTimes("cpu  150 10 60 860 60 5 5 0 40 0\n");
  EXPECT_DOUBLE_EQ(BusyBetween(begin, end), 80.0 / 150.0);
  EXPECT_EQ(BusyBetween(begin, begin), 0.0);
  EXPECT_GT(MachineTimesNow().all, 0u);
}

TEST(ProcessUse, FindsNoServerInWhatHoldsItsPlaceAndIsNone) {
  const int domain = test::OwnDomain();
  EXPECT_FALSE(ServerProcess(domain));
  const ServerLock lock(domain);
  EXPECT_EQ(ServerProcess(domain), getpid());
  EXPECT_FALSE(ServerOf(domain)) << "by its name";
}

TEST(ProcessUse, FindsWhoListensAtAPort) {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  const int port = ntohs(address.sin_port);
  EXPECT_FALSE(ListenerAt(port));
  ASSERT_EQ(listen(listener, 1), 0);
  EXPECT_EQ(ListenerAt(port), getpid());
  close(listener);
}

}  // namespace
}  // namespace palpate
