#include "client/doctor/network_checks.h"

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

const std::vector<Interface> kInterfaces = {{.name = "lo", .up = true},
                                            {.name = "eth0", .up = true, .multicast = true},
                                            {.name = "wg0", .up = true},
                                            {.name = "eth1", .multicast = true}};

dds::Network On(const std::string& interface, const std::vector<std::string>& peers = {}) {
  dds::Network network;
  network.interface = interface;
  network.peers = peers;
  return network;
}

TEST(Network, MustBeThereAndUpAndHaveMulticastOrAPeer) {
  EXPECT_THAT(CheckNetwork(kInterfaces, {}), IsOk());
  EXPECT_THAT(CheckNetwork({}, {}), IsFault("lo is not there", "ip link set lo up"));
  EXPECT_THAT(CheckNetwork(kInterfaces, On("eth0")), IsOk());
  EXPECT_THAT(CheckNetwork(kInterfaces, On("eht0")), IsFault("eht0", "lo eth0 wg0"));
  EXPECT_THAT(CheckNetwork(kInterfaces, On("eth1")), IsFault("down", "ip link set eth1 up"));
  EXPECT_THAT(CheckNetwork(kInterfaces, On("wg0")),
              IsWarning("without multicast", "--peer ADDRESS"));
  EXPECT_THAT(CheckNetwork(kInterfaces, On("wg0", {"10.0.0.2"})), IsOk());
}

class Ports : public testing::Test {
 protected:
  void HoldsPort(const std::string& hexadecimal) const {
    host.Write("/proc/net/udp", "  sl  local_address rem_address\n  12: 0100007F:" + hexadecimal +
                                    " 00000000:0000 07\n");
  }
  MadeUpHost host{{{"/proc/sys/net/ipv4/ip_local_port_range", "32768\t60999\n"}}};
};

TEST_F(Ports, AreFineWhereNobodyHasThemOrTheServerElseAWarningWithFreeDomains) {
  EXPECT_THAT(CheckPorts(host.files, 3, false), IsOk("domain 3, UDP 8060 to 8279: free"));
  HoldsPort("0035");
  EXPECT_THAT(CheckPorts(host.files, 3, false), IsOk());
  HoldsPort("1CF2");  // 7410
  EXPECT_THAT(CheckPorts(host.files, 0, true), IsOk());
  EXPECT_THAT(CheckPorts(host.files, 0, false), IsWarning("--domain 1", "ss -ulpn"));
}

TEST_F(Ports, ThatTheKernelGivesToAnyConnectionAreAWarning) {
  host.Write("/proc/sys/net/ipv4/ip_local_port_range", "1024\t65535\n");
  EXPECT_THAT(CheckPorts(host.files, 0, false), IsWarning("", "net.ipv4.ip_local_port_range"));
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
