#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const ArmProbes kLoads{.openhaptics = [] { return "/usr/lib/libHD.so.3.5 is loaded"; },
                       .forcedimension = [] { return "libdhd.so.3 is loaded"; },
                       .haply = [] { return "a service listens at ws://localhost:10001"; }};
const ArmProbes kLoadsNot{
    .openhaptics = []() -> std::string { throw Error("openhaptics: no libHD.so here"); },
    .forcedimension = []() -> std::string { throw Error("forcedimension: no libdhd here"); },
    .haply = []() -> std::string { throw Error("haply: no Inverse Service"); }};

class Device : public testing::Test {
 protected:
  Device() {
    host.files.may_open = [this](const std::string& path) { return path != closed; };
  }
  Finding Check(const char* device, const ArmProbes& probes = kLoads) const {
    return CheckDevice(host.files, device, probes);
  }
  MadeUpHost host;
  std::string closed;
};

TEST_F(Device, IsAtFaultWhoseLibraryCrashes) {
  ArmProbes probes = kLoads;
  probes.openhaptics = []() -> std::string { std::abort(); };
  EXPECT_THAT(Check("openhaptics", probes),
              IsFault("its library crashed", "PALPATE_OPENHAPTICS_LIBRARY"));
}

TEST_F(Device, OfTheVendorNeedsItsLibraryAndANodeThatMayBeOpened) {
  EXPECT_THAT(Check("openhaptics", kLoadsNot),
              IsFault("no libHD.so here", "PALPATE_OPENHAPTICS_LIBRARY"));
  EXPECT_THAT(Check("openhaptics"), IsWarning("no arm is plugged in"));
  host.Write("/dev/ttyACM0", "");
  EXPECT_THAT(Check("openhaptics"),
              IsOk("openhaptics: /usr/lib/libHD.so.3.5 is loaded; accessible: /dev/ttyACM0"));
  closed = "/dev/ttyACM0";
  EXPECT_THAT(Check("openhaptics"), IsFault(closed, "usermod -aG dialout"));
}

TEST_F(Device, OfForceDimensionNeedsItsLibraryAndAnArmThatMayBeOpened) {
  EXPECT_THAT(Check("forcedimension", kLoadsNot), IsFault("", "PALPATE_FORCEDIMENSION_LIBRARY"));
  EXPECT_THAT(Check("forcedimension"), IsWarning());
  host.Write("/sys/bus/usb/devices/1-2/idVendor", "1451\n");
  host.Write("/sys/bus/usb/devices/1-2/busnum", "1\n");
  host.Write("/sys/bus/usb/devices/1-2/devnum", "12\n");
  EXPECT_THAT(Check("forcedimension"),
              IsOk("libdhd.so.3 is loaded; accessible: /dev/bus/usb/001/012"));
  closed = "/dev/bus/usb/001/012";
  EXPECT_THAT(Check("forcedimension"), IsFault(closed, "udev rule"));
}

TEST_F(Device, OfHaplyNeedsItsService) {
  EXPECT_THAT(Check("haply"), IsOk());
  EXPECT_THAT(Check("haply", kLoadsNot), IsFault("", "systemctl start haply-inverse-service"));
  EXPECT_THAT(Check("haply", kLoadsNot), IsFault("", "PALPATE_HAPLY_SERVICE"));
}

TEST_F(Device, OfSpacenavdNeedsItToRun) {
  EXPECT_THAT(Check("spacemouse"), IsFault("", "apt-get install spacenavd"));
  host.Write("/var/run/spnav.sock", "");
  EXPECT_THAT(Check("spacemouse"), IsWarning("no puck"));
  host.Write("/sys/class/hidraw/hidraw3/device/uevent",
             "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\n");
  EXPECT_THAT(Check("spacemouse"), IsOk("a puck is plugged in"));
  closed = "/var/run/spnav.sock";
  EXPECT_THAT(Check("spacemouse"), IsFault());
}

TEST_F(Device, ThatIsNotNamedIsNoFault) {
  EXPECT_THAT(Check("", kLoadsNot), IsOk());
  EXPECT_THAT(Check("", kLoadsNot).found, Not(HasSubstr("openhaptics")));
  EXPECT_THAT(Check(""), IsOk("openhaptics"));
  EXPECT_THAT(Check("simulated", kLoadsNot), IsOk());
}

/// Wake-ups that are 5 us late and sometimes later.
Finding Check(int wake_ups, std::initializer_list<std::int64_t> late_us, std::uint64_t missed = 0) {
  Jitter jitter{.lateness = {}, .missed = missed};
  for (int i = 0; i < wake_ups; ++i) jitter.lateness.Add(5'000);
  for (const std::int64_t us : late_us) jitter.lateness.Add(1000 * us);
  return CheckJitter(jitter);
}

TEST(Jitter, IsJudgedByWhatIsGoneOfAMillisecondOnceASecondAndByTheWorst) {
  EXPECT_THAT(Check(998, {60, 60}), IsOk());
  EXPECT_THAT(Check(998, {250, 250}), IsWarning());
  EXPECT_THAT(Check(998, {700, 700}), IsFault());
  EXPECT_THAT(Check(10'000, {}), IsOk());
  EXPECT_THAT(Check(10'000, {1500}, 1), IsWarning("1 ms were missed"));
}

TEST(Jitter, IsMeasuredOfEachMillisecondWokenUpForOrMissed) {
  StopSignal stop;
  const Jitter jitter = MeasureJitter(0.3, {}, stop);
  // Each of the 300 was either woken up for or missed; the last may come after the end.
  EXPECT_NEAR(static_cast<double>(jitter.lateness.count() + jitter.missed), 299.0,
              2.0 + static_cast<double>(jitter.missed));
}

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
  EXPECT_THAT(CheckNetwork({}, {}), IsFault("lo does not exist", "ip link set lo up"));
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

TEST(ReceiveBuffer, IsAWarningWhereTheKernelAllowsLittle) {
  const auto check = [](const std::string& bytes) {
    return CheckReceiveBuffer(MadeUpHost({{"/proc/sys/net/core/rmem_max", bytes}}).files);
  };
  EXPECT_THAT(check("212992\n"), IsWarning("holds 208 kB", "sysctl net.core.rmem_max=16777216"));
  EXPECT_THAT(check("4194304\n"), IsOk("4096 kB"));
  EXPECT_THAT(CheckReceiveBuffer(MadeUpHost().files), IsOk()) << "in a container";
}

TEST_F(Ports, AreAServersWhereItHasItsOwn) {
  EXPECT_FALSE(ServerRuns(host.files, 0));
  HoldsPort("1CF2");
  EXPECT_FALSE(ServerRuns(host.files, 0)) << "a station's";
  HoldsPort("1D54");  // 7508
  EXPECT_TRUE(ServerRuns(host.files, 0));
}

using dds::Transport;

constexpr const char* kPools = "/usr/share/palpate/roudi.toml";
constexpr long long kUser = 1000;

/// What a host shows of RouDi.
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
  EXPECT_THAT(Check(Transport::kAuto), IsFault("a program other than RouDi", "ss -xlp"));
  Die();
  EXPECT_THAT(Check(Transport::kAuto), IsWarning("a killed one left its socket"));
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

TEST(SharedMemory, MustBeThereAndHoldRouDisPoolsUnlessItHasThemAlready) {
  const Space container{.size_MB = 64, .free_MB = 64};
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kSharedMemory),
              IsFault("64 of 64 MB free: RouDi needs 117 MB", "--shm-size 256m"));
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kAuto), IsWarning());
  EXPECT_THAT(CheckSharedMemory(container, true, Transport::kAuto), IsOk());
  EXPECT_THAT(CheckSharedMemory(container, false, Transport::kUdp), IsOk());
  EXPECT_THAT(CheckSharedMemory(Space{8000, 3}, false, Transport::kSharedMemory),
              IsFault("", "ls -l /dev/shm"));
  EXPECT_THAT(CheckSharedMemory(Space{8000, 7000}, false, Transport::kAuto), IsOk());
  MadeUpHost host;
  EXPECT_FALSE(SpaceIn(host.files, "/dev/shm"));
  EXPECT_TRUE(SpaceIn(host.files, ""));
  EXPECT_THAT(CheckSharedMemory(std::nullopt, false, Transport::kAuto), IsFault());
}

}  // namespace
}  // namespace palpate::doctor
