#include "client/doctor/processor_checks.h"

#include <cstdint>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::ElementsAre;

const std::string kCpu = "/sys/devices/system/cpu";

class Processor : public testing::Test {
 protected:
  /// Files below kCpu.
  void Has(const std::map<std::string, std::string>& texts) const {
    for (const auto& [file, text] : texts) host.Write(kCpu + "/" + file, text + "\n");
  }
  void IdleState(int state, const std::string& name, int latency_us, bool disabled = false) const {
    const std::string folder = "cpu0/cpuidle/state" + std::to_string(state);
    Has({{folder + "/name", name},
         {folder + "/latency", std::to_string(latency_us)},
         {folder + "/disable", disabled ? "1" : "0"}});
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

TEST_F(Processor, WithOneCoreThatSavesPowerIsAWarning) {
  Has({{"online", "0-1"}});
  EXPECT_THAT(CheckGovernor(host.files), IsOk()) << "without frequencies";
  Has({{"cpu0/cpufreq/scaling_governor", "performance"},
       {"cpu1/cpufreq/scaling_governor", "performance"}});
  EXPECT_THAT(CheckGovernor(host.files), IsOk());
  Has({{"cpu1/cpufreq/scaling_governor", "powersave"}});
  EXPECT_THAT(CheckGovernor(host.files),
              IsWarning("performance, powersave", "cpupower frequency-set -g performance"));
}

TEST_F(Processor, ThatSleepsDeeplyIsAWarningUntilTheStateIsSwitchedOff) {
  Has({{"online", "0"}});
  EXPECT_THAT(CheckIdleStates(host.files), IsOk()) << "without states";
  IdleState(0, "POLL", 0);
  IdleState(1, "C1", 2);
  IdleState(2, "C6", 133);
  EXPECT_THAT(CheckIdleStates(host.files),
              IsWarning("C6, 133 us to leave", "cpupower idle-set -D 10"));
  IdleState(2, "C6", 133, true);
  EXPECT_THAT(CheckIdleStates(host.files), IsOk());
}

TEST_F(Processor, ThatAProgramKeepsAwakeIsFineHoweverDeepItCouldSleep) {
  Has({{"online", "0"}});
  IdleState(0, "C6", 133);
  DmaLatency(2'000'000'000);
  EXPECT_THAT(CheckIdleStates(host.files), IsWarning());
  DmaLatency(0);
  EXPECT_THAT(CheckIdleStates(host.files), IsOk());
}

TEST_F(Processor, NeedsAnIsolatedCoreWithoutTicks) {
  Has({{"online", "0-3"}, {"isolated", ""}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("none isolated", "isolcpus=3"));
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("", "--cpu 3"));
  Has({{"online", "0-7"}, {"isolated", "6-7"}, {"nohz_full", "  (null)"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("", "nohz_full=6-7 rcu_nocbs=6-7"));
  Has({{"isolated", "7"}, {"nohz_full", "7"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsOk("8 cores, 7 isolated"));
}

TEST_F(Processor, OfTwoCoresIsNotToldToGiveOneAway) {
  Has({{"online", "0-1"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("2 cores: none to spare"));
  EXPECT_THAT(CheckIsolatedCores(host.files).remedy, testing::Not(testing::HasSubstr("isolcpus")));
}

TEST_F(Processor, WithHyperThreadingIsAWarningUnlessACoreIsIsolatedWhole) {
  EXPECT_THAT(CheckHyperThreading(host.files), IsOk());
  Has({{"smt/active", "1"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsWarning());
  Has({{"isolated", "3"}, {"cpu3/topology/thread_siblings_list", "3,7"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsWarning()) << "half of it";
  Has({{"isolated", "3,7"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsOk());
}

}  // namespace
}  // namespace palpate::doctor
