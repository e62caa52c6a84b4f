#include "common/program/machine.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <sched.h>

#include "tests/support/folder.h"

namespace palpate {
namespace {

TEST(Machine, HasTheCoresThatThisProcessMayRunOn) {
  cpu_set_t all;
  sched_getaffinity(0, sizeof all, &all);
  EXPECT_EQ(UsableCores("/nowhere"), CPU_COUNT(&all));
  EXPECT_EQ(ThisHost().cores, UsableCores());
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(ThisHost().cores, 1);
  sched_setaffinity(0, sizeof all, &all);
}

/// A root whose control group has the given files.
class Groups {
 public:
  Groups(const std::string& line, const std::map<std::string, std::string>& files) {
    Write("proc/self/cgroup", "3:cpuset:/none\n" + line + "\n");
    for (const auto& [file, text] : files) Write("sys/fs/cgroup/" + file, text);
  }
  /// Cores, as far as this host has them.
  int Cores() const { return UsableCores(folder_.path()); }

 private:
  void Write(const std::string& file, const std::string& text) {
    const std::filesystem::path path = folder_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  test::Folder folder_;
};

TEST(Machine, HasTheCoresOfAContainersQuotaRoundedUp) {
  const int all = UsableCores("/nowhere");
  EXPECT_GE(all, 1);
  const std::string v2 = "0::/pod/box", v1 = "4:cpu,cpuacct:/pod/box";
  EXPECT_EQ(Groups(v2, {{"pod/box/cpu.max", "50000 100000\n"}}).Cores(), 1);
  EXPECT_EQ(Groups(v2, {{"pod/box/cpu.max", "150000 100000\n"}}).Cores(), std::min(2, all));
  EXPECT_EQ(Groups(v2, {{"pod/box/cpu.max", "max 100000\n"}}).Cores(), all);
  EXPECT_EQ(Groups(v1, {{"cpu,cpuacct/pod/box/cpu.cfs_quota_us", "100000\n"},
                        {"cpu,cpuacct/pod/box/cpu.cfs_period_us", "100000\n"}})
                .Cores(),
            1);
  EXPECT_EQ(Groups(v1, {{"cpu/pod/box/cpu.cfs_quota_us", "-1\n"},
                        {"cpu/pod/box/cpu.cfs_period_us", "100000\n"}})
                .Cores(),
            all);
}

TEST(Machine, HasTheQuotaOfTheGroupsAboveAndOfAContainerThatSeesTheHostsPath) {
  const std::string v2 = "0::/pod/box";
  EXPECT_EQ(
      Groups(v2, {{"pod/cpu.max", "100000 100000"}, {"pod/box/cpu.max", "max 100000"}}).Cores(), 1);
  EXPECT_EQ(Groups(v2, {{"cpu.max", "20000 100000"}}).Cores(), 1);
  EXPECT_EQ(Groups("0::/../other", {{"cpu.max", "20000 100000"}}).Cores(), 1);
}

TEST(Machine, NamesItsProcessorAndCompiler) {
  EXPECT_NE(ThisHost().cpu, "");
  EXPECT_NE(ThisHost().compiler.find("GCC "), std::string::npos);
}

}  // namespace
}  // namespace palpate
