#include <map>
#include <sstream>

#include <sched.h>

#include "common/error.h"
#include "tests/doctor/made_up_host.h"
#include "tests/support/approved.h"

namespace palpate::doctor {
namespace {

const ArmProbes kLoads{.openhaptics = [] { return "/usr/lib/libHD.so.3.5 is loaded"; },
                       .forcedimension = [] { return "libdhd.so.3 is loaded"; },
                       .haply = [] { return "a service listens at ws://localhost:10001"; }};
const ArmProbes kLoadsNot{
    .openhaptics = []() -> std::string { throw Error("openhaptics: no libHD.so here"); },
    .forcedimension = []() -> std::string { throw Error("forcedimension: no libdhd here"); },
    .haply = []() -> std::string { throw Error("haply: no Inverse Service"); }};
const ArmProbes kCrashes{
    .openhaptics = []() -> std::string { std::abort(); }, .forcedimension = {}, .haply = {}};

const std::vector<Interface> kInterfaces = {{.name = "lo", .up = true},
                                            {.name = "eth0", .up = true, .multicast = true},
                                            {.name = "wg0", .up = true},
                                            {.name = "eth1", .multicast = true}};

std::function<Finding(const HostFiles&)> Arm(const char* device, const ArmProbes& probes = kLoads) {
  return [=](const HostFiles& host) { return CheckDevice(host, device, probes); };
}
std::function<Finding(const HostFiles&)> Scheduling(const Rights& rights) {
  return [=](const HostFiles& host) { return CheckScheduling(host, rights, 40); };
}
std::function<Finding(const HostFiles&)> PortsOf(int domain, bool server_runs) {
  return [=](const HostFiles& host) { return CheckPorts(host, domain, server_runs); };
}
std::function<Finding(const HostFiles&)> NetworkOn(const std::string& interface,
                                                   std::vector<std::string> peers = {}) {
  return [=](const HostFiles&) {
    dds::Network network;
    network.interface = interface;
    network.peers = peers;
    return CheckNetwork(kInterfaces, network);
  };
}
std::function<Finding(const HostFiles&)> Memory(std::optional<Space> space, bool roudi_runs,
                                                dds::Transport wanted) {
  return [=](const HostFiles&) { return CheckSharedMemory(space, roudi_runs, wanted); };
}

const Space kContainer{.size_MB = 64, .free_MB = 64}, kFull{8000, 3}, kLarge{8000, 7000};
using dds::Transport;

/// What the cases in findings.txt call them.
const std::map<std::string, std::function<Finding(const HostFiles&)>> kChecks{
    {"kernel", CheckKernel},
    {"clock source", CheckClockSource},
    {"scheduling, SCHED_FIFO granted", Scheduling({.fifo = true})},
    {"scheduling, rtprio 0", Scheduling({.rtprio = 0})},
    {"scheduling, rtprio unlimited", Scheduling({.rtprio = std::nullopt})},
    {"locked memory, granted",
     [](const HostFiles&) { return CheckLockedMemory({.memory_locked = true}); }},
    {"locked memory, 8192 kB",
     [](const HostFiles&) { return CheckLockedMemory({.memlock_kB = 8192}); }},
    {"throttling", CheckThrottling},
    {"governor", CheckGovernor},
    {"idle states", CheckIdleStates},
    {"isolated cores", CheckIsolatedCores},
    {"hyper-threading", CheckHyperThreading},
    {"receive buffer", CheckReceiveBuffer},
    {"ports of domain 3", PortsOf(3, false)},
    {"ports of domain 0", PortsOf(0, false)},
    {"ports of domain 0, of a server", PortsOf(0, true)},
    {"network, any", [](const HostFiles&) { return CheckNetwork(kInterfaces, dds::Network()); }},
    {"network, of no interface", [](const HostFiles&) { return CheckNetwork({}, dds::Network()); }},
    {"network on eth0", NetworkOn("eth0")},
    {"network on eht0", NetworkOn("eht0")},
    {"network on eth1", NetworkOn("eth1")},
    {"network on wg0", NetworkOn("wg0")},
    {"network on wg0 to a peer", NetworkOn("wg0", {"10.0.0.2"})},
    {"shared memory, a container's", Memory(kContainer, false, Transport::kSharedMemory)},
    {"shared memory, a container's, if there is", Memory(kContainer, false, Transport::kAuto)},
    {"shared memory, a container's, RouDi runs", Memory(kContainer, true, Transport::kAuto)},
    {"shared memory, a container's, over UDP", Memory(kContainer, false, Transport::kUdp)},
    {"shared memory, full", Memory(kFull, false, Transport::kSharedMemory)},
    {"shared memory, large", Memory(kLarge, false, Transport::kAuto)},
    {"shared memory, none", Memory(std::nullopt, false, Transport::kAuto)},
    {"no device", Arm("", kLoadsNot)},
    {"no device, vendors' libraries there", Arm("")},
    {"simulated", Arm("simulated", kLoadsNot)},
    {"openhaptics", Arm("openhaptics")},
    {"openhaptics without its library", Arm("openhaptics", kLoadsNot)},
    {"openhaptics, whose library crashes", Arm("openhaptics", kCrashes)},
    {"forcedimension", Arm("forcedimension")},
    {"forcedimension without its library", Arm("forcedimension", kLoadsNot)},
    {"haply", Arm("haply")},
    {"haply without its service", Arm("haply", kLoadsNot)},
    {"spacemouse", Arm("spacemouse")},
};

std::string WithLineEnds(std::string text) {
  for (std::size_t at; (at = text.find("\\n")) != text.npos;) text.replace(at, 2, "\n");
  return text;
}

/// Each case of the file is the name of a check, a line for each file of a made-up host ("| PATH
/// TEXT") or for one that this user may not open ("! PATH"), and the finding ("= ..."), which is
/// made anew.
TEST(Findings, AreThoseThatPeopleHaveApproved) {
  constexpr const char* kFile = "tests/doctor/findings.txt";
  std::filesystem::current_path(PALPATE_SOURCE_DIR);  // paths are shown from there
  std::istringstream in(ReadWholeFile(std::string(PALPATE_SOURCE_DIR "/") + kFile));
  std::string found;
  for (std::string name; std::getline(in, name);) {
    found += name + "\n";
    if (name.empty() || name[0] == '#') continue;
    ASSERT_TRUE(kChecks.contains(name)) << name;
    MadeUpHost host;
    std::string closed;
    host.files.may_open = [&](const std::string& path) { return path != closed; };
    std::string line;
    while (std::getline(in, line) && !line.empty() && line[0] != '=') {
      found += line + "\n";
      const std::size_t end = std::min(line.find(' ', 2), line.size());
      const std::string text = line.substr(std::min(end + 1, line.size()));
      if (line[0] == '!') closed = line.substr(2);
      if (line[0] == '|') host.Write(line.substr(2, end - 2), WithLineEnds(text) + "\n");
    }
    const Finding finding = kChecks.at(name)(host.files);
    constexpr const char* kStatus[] = {"ok", "warning", "fault"};
    found += "= " + std::string(kStatus[static_cast<int>(finding.status)]) + ": " + finding.found;
    found += finding.remedy.empty() ? "\n" : " -> " + finding.remedy + "\n";
    EXPECT_EQ(finding.remedy.empty(), finding.status == Status::kOk) << name;
  }
  test::ExpectApproved(kFile, found);
}

TEST(Rights, AreTriedWithoutLeavingThisThreadARealtimeOne) {
  TryRights({});
  EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
}

TEST(CoreList, ReadsAndWritesTheKernelsWay) {
  EXPECT_THAT(ParseCores("0-2,5,7-8"), testing::ElementsAre(0, 1, 2, 5, 7, 8));
  EXPECT_EQ(ToText({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
  EXPECT_TRUE(ParseCores("").empty());
  EXPECT_TRUE(ParseCores("(null)").empty()) << "as nohz_full says where there is none";
  EXPECT_LT(ParseCores("0-99999999999").size(), 10'000u);
}

TEST(IdleStates, AreFineWhereAProgramKeepsTheProcessorAwake) {
  const std::string state = "/sys/devices/system/cpu/cpu0/cpuidle/state0/";
  const MadeUpHost host({{"/sys/devices/system/cpu/online", "0\n"},
                         {state + "name", "C6\n"},
                         {state + "latency", "133\n"},
                         {state + "disable", "0\n"}});
  for (const std::int32_t latency_us : {2'000'000'000, 0}) {
    host.Write("/dev/cpu_dma_latency",
               std::string(reinterpret_cast<const char*>(&latency_us), sizeof latency_us));
    EXPECT_EQ(CheckIdleStates(host.files).status, latency_us == 0 ? Status::kOk : Status::kWarning);
  }
}

}  // namespace
}  // namespace palpate::doctor
