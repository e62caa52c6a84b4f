#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "client/doctor/report.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/program/command_line.h"
#include "common/program/machine.h"
#include "common/program/stop_signal.h"
#include "devices/device_factory.h"

namespace palpate::doctor {
namespace {

struct Options {
  double seconds = 10.0;  ///< of the jitter test; 0: none
  std::string device{};   ///< as after palpate-station --device; empty: none
  std::string arm{};
  bool push = false;
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network{};
  RealtimeOptions realtime{};
  bool json = false;
  int domain = 0;
  std::string log_level = "warn";
};

constexpr const char* kAbout =
    R"(Checks whether this host can run a haptic loop at 1 kHz; says what to change.
Examines kernel, rights, processor, shared memory, RouDi, network and device;
runs a loop of poses and wrenches; and measures how late a thread wakes up.  It
changes nothing.  Run it as the user of server and station, under the host's
usual load.  A device driver of your own is also run as in a station, without a
force.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-doctor
  palpate-doctor --device openhaptics --transport shm --seconds 60
      for the host of an arm, which needs shared memory
  palpate-doctor --device ./mine.so --push
      also tests a driver of your own; move the handle meanwhile
  palpate-doctor --json |
      jq -r '.findings[] | select(.status != "ok") | .remedy'

Exit status: 0 fit (perhaps with warnings), 1 not fit, 2 wrong usage.)";

/// Returns nothing after --help or --version.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  const CommandLine app(kAbout, "palpate-doctor", kExamples);
  app.Add("--seconds", options.seconds,
          "how long to measure the lateness of a loop, in seconds; 0: do not measure")
      .Range(0.0, 86400.0)
      .ShowDefault();
  app.Add("--device", options.device,
          "device that a station on this host will drive: " + DeviceNames())
      .TypeName("NAME");
  const Option arm = app.Add("--device-name", options.arm,
                             "with a driver of your own: arm to use if there are several");
  const Option push = app.AddFlag("--push", options.push,
                                  "with a driver of your own: push the handle with 1 N along each "
                                  "axis and check that it moves; hold it loosely meanwhile");
  AddTransportOption(app, options.transport);
  app.AddFlag("--json", options.json, "print one JSON object instead of the report");
  AddNetworkOptions(app, "the other host", options.network);
  AddRealtimeOptions(app, "the loops it runs", options.realtime);
  AddCommonOptions(app, "number of the domain in which ports and loop are tried", options.domain,
                   options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (!options.device.empty()) DeviceNeedsScript(options.device);  // throws for an unknown name
  if ((push.given() || arm.given()) && !IsDriverFile(options.device)) {
    throw UsageError(std::string(push.given() ? "--push" : "--device-name") +
                     " needs a driver of your own; give its file with --device");
  }
  if (options.transport == dds::Transport::kSharedMemory && !options.network.this_host()) {
    throw UsageError("--transport shm works within one host only; omit --network");
  }
  return options;
}

/// Returns the transport that the trial loop should use.
dds::Transport Expected(const Options& options, const RouDiState& roudi) {
  if (options.transport == dds::Transport::kUdp || !options.network.this_host()) {
    return dds::Transport::kUdp;
  }
  if (options.transport == dds::Transport::kSharedMemory) return dds::Transport::kSharedMemory;
  return roudi.answers && roudi.lock_held ? dds::Transport::kSharedMemory : dds::Transport::kUdp;
}

/// Returns, for instance, "lab-3: AMD Ryzen 7 5700G, 8 cores".
std::string HostLine() {
  char name[256] = "this host";
  gethostname(name, sizeof name - 1);
  const HostMachine machine = ThisHost();
  return fmt::format("{}: {}, {} core{}", name, machine.cpu, machine.cores,
                     machine.cores == 1 ? "" : "s");
}

/// Runs all checks of this host, in the order in which to fix their faults; returns nothing if the
/// user stopped it.  Call it while this process has no other thread.
/// @param found      called with each finding.
/// @param measuring  called with the name of each slow check before it starts.
std::optional<Report> Examine(const Options& options, StopSignal& stop,
                              const std::function<void(const Finding&)>& found,
                              const std::function<void(const std::string&)>& measuring) {
  const HostFiles host;
  Report report{.host = HostLine()};
  const auto add = [&](const char* check, Finding finding) {
    finding.check = check;
    found(finding);
    report.findings.push_back(std::move(finding));
  };
  add("kernel", CheckKernel(host));
  add("clock source", CheckClockSource(host));

  const Rights rights = TryRights(options.realtime);
  add("real-time rights", CheckScheduling(host, rights, options.realtime.priority));
  add("real-time throttling", CheckThrottling(host));
  add("locked memory", CheckLockedMemory(rights));

  add("processor frequency", CheckGovernor(host));
  add("idle states", CheckIdleStates(host));
  add("isolated cores", CheckIsolatedCores(host));
  add("hyper-threading", CheckHyperThreading(host));

  const dds::Transport wanted =
      options.network.this_host() ? options.transport : dds::Transport::kUdp;
  const RouDiState roudi = LookAtRouDi(host);
  add("/dev/shm", CheckSharedMemory(SpaceIn(host, "/dev/shm"), roudi.lock_held, wanted));
  add("RouDi", CheckRouDi(roudi, wanted, getuid(), ShownPlaceOf(ProjectFile::kSharedMemory)));

  add("network", CheckNetwork(InterfacesOfThisHost(), options.network));
  add("receive buffer", CheckReceiveBuffer(host));
  add("ports", CheckPorts(host, options.domain, ServerRuns(host, options.domain)));

  measuring("a loop of poses and wrenches");
  const dds::Transport expected = Expected(options, roudi);
  add("loop", CheckLoop(TryLoop({.domain = options.domain,
                                 .transport = expected,
                                 .network = options.network,
                                 .realtime = options.realtime},
                                stop),
                        expected));
  if (IsDriverFile(options.device)) {
    measuring("the driver");
    DeviceOptions device;
    device.name = options.device;
    device.arm = options.arm;
    device.realtime = options.realtime;
    for (const Finding& finding : TryDriver(device, options.push, stop)) {
      add(finding.check.c_str(), finding);
    }
  } else {
    add("device", CheckDevice(host, options.device, RealArmProbes()));
  }

  if (options.seconds > 0.0 && !stop.stopped()) {
    measuring(fmt::format("the lateness of a loop, for {:g} s", options.seconds));
    report.jitter = MeasureJitter(options.seconds, options.realtime, stop);
    if (!stop.stopped()) add("jitter", CheckJitter(*report.jitter));
  }
  if (stop.stopped()) return std::nullopt;
  return report;
}

Style StyleOfOutput() {
  Style style;
  if (isatty(STDOUT_FILENO) != 1) return style;
  style.colours = std::getenv("NO_COLOR") == nullptr;
  winsize window{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0) {
    style.columns = window.ws_col;
  }
  return style;
}

/// Prints a line that the next output replaces.
void SayForNow(const std::string& what) {
  if (isatty(STDERR_FILENO) == 1) std::fprintf(stderr, "  measuring %s ...\r", what.c_str());
}
void WipeForNow() {
  if (isatty(STDERR_FILENO) == 1) std::fputs("\x1b[2K", stderr);
}

int Run(const Options& options) {
  const Style style = StyleOfOutput();
  StopSignal stop;
  if (!options.json) {
    std::printf("palpate-doctor %s on %s\n\n", PALPATE_VERSION, HostLine().c_str());
    std::fflush(stdout);
  }
  const auto report = Examine(
      options, stop,
      [&](const Finding& finding) {
        WipeForNow();
        if (options.json) return;
        std::fputs(ToText(finding, style).c_str(), stdout);
        std::fflush(stdout);
      },
      SayForNow);
  if (!report) {
    std::fputs("palpate-doctor: stopped before a verdict\n", stderr);
    return 1;
  }
  const std::string end = options.json ? ToJson(*report) : Summary(*report, style);
  std::fputs(end.c_str(), stdout);
  return Worst(report->findings) == Status::kFault ? 1 : 0;
}

}  // namespace
}  // namespace palpate::doctor

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-doctor", argc, argv, palpate::doctor::ParseOptions,
                             palpate::doctor::Run);
}
