#include "client/doctor/processor_checks.h"

#include <cstdint>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/doctor/core_list.h"
#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kCpu = "/sys/devices/system/cpu";

class Processor : public testing::Test {
 protected:
  void HasCores(const std::string& list) const { host.Write(kCpu + "/online", list + "\n"); }
  void Governor(int core, const std::string& governor) const {
    host.Write(kCpu + "/cpu" + std::to_string(core) + "/cpufreq/scaling_governor", governor + "\n");
  }
  void IdleState(int core, int state, const std::string& name, int latency_us,
                 bool disabled) const {
    const std::string folder =
        kCpu + "/cpu" + std::to_string(core) + "/cpuidle/state" + std::to_string(state);
    host.Write(folder + "/name", name + "\n");
    host.Write(folder + "/latency", std::to_string(latency_us) + "\n");
    host.Write(folder + "/disable", disabled ? "1\n" : "0\n");
  }
  void DmaLatency(std::int32_t latency_us) const {
    host.Write("/dev/cpu_dma_latency",
               std::string(reinterpret_cast<const char*>(&latency_us), sizeof latency_us));
  }
  MadeUpHost host;
};

TEST(CoreList, ReadsAndWritesTheKernelsWay) {
  EXPECT_THAT(ParseCores("0-2,5,7-8"), ElementsAre(0, 1, 2, 5, 7, 8));
  EXPECT_EQ(ToText({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
  EXPECT_TRUE(ParseCores("").empty());
  EXPECT_TRUE(ParseCores("(null)").empty()) << "as nohz_full says where there is none";
  EXPECT_LT(ParseCores("0-99999999999").size(), 10'000u);
}

TEST_F(Processor, AtPerformanceOnEachCoreIsFine) {
  HasCores("0-1");
  Governor(0, "performance");
  Governor(1, "performance");
  EXPECT_EQ(CheckGovernor(host.files).status, Status::kOk);
}

TEST_F(Processor, WithOneCoreThatSavesPowerIsAWarning) {
  HasCores("0-1");
  Governor(0, "performance");
  Governor(1, "powersave");
  const Finding finding = CheckGovernor(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("performance, powersave"));
  EXPECT_THAT(finding.remedy, HasSubstr("cpupower frequency-set -g performance"));
}

TEST_F(Processor, WithoutFrequenciesIsFine) {
  HasCores("0-1");
  EXPECT_EQ(CheckGovernor(host.files).status, Status::kOk);
  EXPECT_EQ(CheckIdleStates(host.files).status, Status::kOk);
}

TEST_F(Processor, ThatSleepsDeeplyIsAWarningUntilTheStateIsSwitchedOff) {
  HasCores("0");
  IdleState(0, 0, "POLL", 0, false);
  IdleState(0, 1, "C1", 2, false);
  IdleState(0, 2, "C6", 133, false);
  const Finding deep = CheckIdleStates(host.files);
  EXPECT_EQ(deep.status, Status::kWarning);
  EXPECT_THAT(deep.found, HasSubstr("C6, 133 us to leave"));
  EXPECT_THAT(deep.remedy, HasSubstr("cpupower idle-set -D 10"));
  IdleState(0, 2, "C6", 133, true);
  EXPECT_EQ(CheckIdleStates(host.files).status, Status::kOk);
}

TEST_F(Processor, ThatAProgramKeepsAwakeIsFineHoweverDeepItCouldSleep) {
  HasCores("0");
  IdleState(0, 0, "C6", 133, false);
  DmaLatency(2'000'000'000);
  EXPECT_EQ(CheckIdleStates(host.files).status, Status::kWarning);
  DmaLatency(0);
  EXPECT_EQ(CheckIdleStates(host.files).status, Status::kOk);
}

TEST_F(Processor, WithAnIsolatedCoreWithoutTicksIsFine) {
  HasCores("0-7");
  host.Write(kCpu + "/isolated", "7\n");
  host.Write(kCpu + "/nohz_full", "7\n");
  const Finding finding = CheckIsolatedCores(host.files);
  EXPECT_EQ(finding.status, Status::kOk);
  EXPECT_THAT(finding.found, HasSubstr("8 cores, 7 isolated"));
}

TEST_F(Processor, WithAnIsolatedCoreThatTicksIsToldTheOption) {
  HasCores("0-7");
  host.Write(kCpu + "/isolated", "6-7\n");
  host.Write(kCpu + "/nohz_full", "  (null)\n");
  const Finding finding = CheckIsolatedCores(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.remedy, HasSubstr("nohz_full=6-7 rcu_nocbs=6-7"));
}

TEST_F(Processor, WithoutIsolatedCoresIsToldToGiveItsLast) {
  HasCores("0-3");
  host.Write(kCpu + "/isolated", "\n");
  const Finding finding = CheckIsolatedCores(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.remedy, HasSubstr("isolcpus=3"));
  EXPECT_THAT(finding.remedy, HasSubstr("--cpu 3"));
}

TEST_F(Processor, OfTwoCoresIsNotToldToGiveOneAway) {
  HasCores("0-1");
  const Finding finding = CheckIsolatedCores(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("2 cores: none to spare"));
  EXPECT_THAT(finding.remedy, testing::Not(HasSubstr("isolcpus")));
}

TEST_F(Processor, WithHyperThreadingIsAWarningUnlessACoreIsIsolatedWhole) {
  EXPECT_EQ(CheckHyperThreading(host.files).status, Status::kOk);
  host.Write(kCpu + "/smt/active", "1\n");
  EXPECT_EQ(CheckHyperThreading(host.files).status, Status::kWarning);
  host.Write(kCpu + "/isolated", "3\n");
  host.Write(kCpu + "/cpu3/topology/thread_siblings_list", "3,7\n");
  EXPECT_EQ(CheckHyperThreading(host.files).status, Status::kWarning) << "half of it";
  host.Write(kCpu + "/isolated", "3,7\n");
  EXPECT_EQ(CheckHyperThreading(host.files).status, Status::kOk);
}

}  // namespace
}  // namespace palpate::doctor
