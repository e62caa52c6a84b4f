#include "client/doctor/network_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;

const std::vector<Interface> kInterfaces = {{.name = "lo", .up = true},
                                            {.name = "eth0", .up = true, .multicast = true},
                                            {.name = "wg0", .up = true},
                                            {.name = "eth1", .multicast = true}};

TEST(Network, OfThisHostNeedsItsLoopbackAlone) {
  EXPECT_EQ(CheckNetwork(kInterfaces, {}).status, Status::kOk);
  const Finding none = CheckNetwork({}, {});
  EXPECT_EQ(none.status, Status::kFault);
  EXPECT_THAT(none.remedy, HasSubstr("ip link set lo up"));
}

TEST(Network, ThatIsNotThereOrDownIsAFault) {
  EXPECT_EQ(CheckNetwork(kInterfaces, {"eth0", {}}).status, Status::kOk);
  const Finding misspelt = CheckNetwork(kInterfaces, {"eht0", {}});
  EXPECT_EQ(misspelt.status, Status::kFault);
  EXPECT_THAT(misspelt.remedy, HasSubstr("lo eth0 wg0"));
  const Finding down = CheckNetwork(kInterfaces, {"eth1", {}});
  EXPECT_EQ(down.status, Status::kFault);
  EXPECT_THAT(down.remedy, HasSubstr("ip link set eth1 up"));
}

TEST(Network, WithoutMulticastNeedsAPeer) {
  const Finding finding = CheckNetwork(kInterfaces, {"wg0", {}});
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.remedy, HasSubstr("--peer ADDRESS"));
  EXPECT_EQ(CheckNetwork(kInterfaces, {.interface = "wg0", .peers = {"10.0.0.2"}}).status,
            Status::kOk);
}

class Ports : public testing::Test {
 protected:
  Ports() { host.Write("/proc/sys/net/ipv4/ip_local_port_range", "32768\t60999\n"); }
  void HoldsPort(const std::string& hexadecimal) const {
    host.Write("/proc/net/udp", "  sl  local_address rem_address\n  12: 0100007F:" + hexadecimal +
                                    " 00000000:0000 07\n");
  }
  MadeUpHost host;
};

TEST_F(Ports, ThatNobodyHasAreFine) {
  const Finding finding = CheckPorts(host.files, 3, false);
  EXPECT_EQ(finding.status, Status::kOk);
  EXPECT_EQ(finding.found, "domain 3, UDP 8060 to 8279: free");
  HoldsPort("0035");
  EXPECT_EQ(CheckPorts(host.files, 3, false).status, Status::kOk);
}

TEST_F(Ports, ThatTheServerHasAreFineAndOthersAWarningWithFreeDomains) {
  HoldsPort("1CF2");  // 7410
  EXPECT_EQ(CheckPorts(host.files, 0, true).status, Status::kOk);
  const Finding finding = CheckPorts(host.files, 0, false);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("--domain 1"));
  EXPECT_THAT(finding.remedy, HasSubstr("ss -ulpn"));
}

TEST_F(Ports, ThatTheKernelGivesToAnyConnectionAreAWarning) {
  host.Write("/proc/sys/net/ipv4/ip_local_port_range", "1024\t65535\n");
  const Finding finding = CheckPorts(host.files, 0, false);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.remedy, HasSubstr("net.ipv4.ip_local_port_range"));
}

TEST_F(Ports, AreAServersWhereItHasItsOwn) {
  EXPECT_FALSE(ServerRuns(host.files, 0));
  HoldsPort("1CF2");
  EXPECT_FALSE(ServerRuns(host.files, 0)) << "a station's";
  HoldsPort("1D54");  // 7508
  EXPECT_TRUE(ServerRuns(host.files, 0));
}

}  // namespace
}  // namespace palpate::doctor
