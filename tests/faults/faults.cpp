#include "tests/faults/faults.h"

#include <csignal>
#include <fstream>

#include <spdlog/fmt/fmt.h>
#include <sys/mount.h>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "common/error.h"
#include "common/math/random.h"
#include "tests/faults/hostile.h"
#include "tests/support/roudi.h"

namespace palpate::faults {
namespace {

namespace fs = std::filesystem;

void Freeze(const test::Program& program, double seconds) {
  program.Signal(SIGSTOP);
  Wait(seconds);
  program.Signal(SIGCONT);
}

Findings ServerKilled(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartRecorder();
  lab.StartStation();
  Wait(1.5);
  lab.server->Signal(SIGKILL);
  Wait(0.3);  // not for DDS to miss it
  lab.StartServer();
  Findings findings{Resumes(lab), LoopRuns(lab)};
  lab.recorder->Signal(SIGINT);
  lab.recorder->Exit();
  const FileSummary summary = Summarise({lab.recording()});
  findings.push_back(
      {"what both servers' sessions were is recorded from their first pose",
       fmt::format("{} missing, {}", summary.missing, summary.intact() ? "whole" : "incomplete"),
       summary.intact()});
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

Findings ServerFrozen(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  Wait(1.5);
  Freeze(*lab.server, 5.0);
  return {LoopRuns(lab), Lives("the server", *lab.server), lab.JudgeTheHand()};
}

Findings StationKilled(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  Wait(1.0);
  lab.station->Signal(SIGKILL);
  const auto successor = lab.AnotherStation("next", "cube");
  // It is refused until the server notices; then a person would start it again.
  Finding free{"its tool is free for another", "", false};
  auto next = lab.AnotherStation("other", "cube");
  for (int i = 0; i < 10 && !free.held; ++i) {
    free.held = next->Says("session: tool", 3.0);
    if (!free.held && !next->Runs()) next = lab.AnotherStation("other", "cube");
  }
  free.held |= successor->Says("session: tool", 0.1);
  free.found = free.held ? "another has it" : next->Output();
  return {free, Lives("the server", *lab.server)};
}

Findings StationFrozen(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  Wait(1.5);
  Freeze(*lab.station, 4.0);
  return {Says("the server says why it ended the session", *lab.server,
               "no pose came for more than 100 ms"),
          Says("the station has its tool back", *lab.station, "session resumed: forces ramp in"),
          LoopRuns(lab), lab.JudgeTheHand()};
}

Findings GatewayKilledAndFrozen(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  lab.StartGateway();
  Wait(1.0);
  const std::string before = lab.station->Output();
  Freeze(*lab.gateway, 5.0);
  Wait(0.5);
  lab.gateway->Signal(SIGKILL);
  lab.gateway->Exit();
  lab.StartGateway();
  return {Shows("a new gateway shows the scene", lab), Undisturbed(lab, before),
          lab.JudgeTheHand()};
}

Findings GatewayBlinded(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartGateway();
  Finding sees = Shows("the gateway goes on showing the server that lives", lab);
  FloodDomain(domain, 1, 2.0);
  sees.held &= lab.Get("/healthz").find("\"cube\"") != std::string::npos;
  sees.found = sees.held ? "it does" : "it does not";
  return {sees, Lives("the gateway", *lab.gateway)};
}

Findings RecorderFrozen(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartRecorder();
  lab.StartStation();
  Wait(1.0);
  const std::string before = lab.station->Output();
  Freeze(*lab.recorder, 4.0);
  Wait(1.0);
  return {Undisturbed(lab, before), EndsInOrder("the recorder", *lab.recorder), lab.JudgeTheHand()};
}

Findings DiskFull(int domain) {
  Lab lab(domain);
  const fs::path disk = lab.folder() / "disk";
  fs::create_directories(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=640k") != 0) {
    return {{"a full disk is told", "skipped: only root can make a small disk", true}};
  }
  Findings findings;
  {
    lab.StartServer();
    const std::string file = disk / "lesson.mcap";
    test::Program recorder(test::OwnFolder() + "/palpate-record",
                           {"-o", file, "--transport", "udp", "--domain", std::to_string(domain)});
    recorder.Says("recording to ");
    lab.StartStation();
    const int exit = recorder.Exit(60.0);
    findings.push_back({"the recorder ends and says that the disk is full",
                        fmt::format("exit status {}", exit),
                        exit == 1 && recorder.Output().find("No space left") != std::string::npos});
    findings.push_back(Says("and that what it had written is whole", recorder,
                            "the recording up to then is complete"));
    const FileSummary summary = Summarise({file});
    findings.push_back({"what it had written is whole",
                        fmt::format("{} messages, {} missing", summary.messages, summary.missing),
                        summary.messages > 100 && summary.missing == 0});
    findings.push_back(LoopRuns(lab));
    findings.push_back(lab.JudgeTheHand());
  }
  umount(disk.c_str());
  return findings;
}

/// This process's RouDi, until the process ends (tests/support/roudi.h).  Only one can run on a
/// host: null, with a finding that says so, if another does.
RouDi* OwnRouDi(Findings& findings) {
  static std::unique_ptr<RouDi> roudi;
  if (!roudi && RouDi::AnotherRuns()) {
    findings.push_back({"(RouDi)", "skipped: another RouDi runs on this host", true});
    return nullptr;
  }
  if (!roudi) roudi = std::make_unique<RouDi>();
  return roudi.get();
}

test::Program AnotherRouDi() {
  return test::Program("/usr/bin/iox-roudi",
                       {"-c", PALPATE_SOURCE_DIR "/deploy/cyclonedds/roudi.toml"});
}

Findings RouDiKilled(int domain) {
  Findings findings;
  RouDi* const roudi = OwnRouDi(findings);
  if (roudi == nullptr) return findings;
  Lab lab(domain, "auto");
  lab.StartServer();
  lab.StartStation();
  Wait(1.0);
  const std::string before = lab.station->Output();
  roudi->Kill();
  Wait(2.0);
  findings.push_back(Undisturbed(lab, before));
  findings.push_back(Lives("the server", *lab.server));
  findings.push_back(Says("the server says what to do", *lab.server, "RouDi has ended"));
  // systemd would start it again.  The last fault that uses RouDi, which ends with this one.
  test::Program successor = AnotherRouDi();
  lab.server->Signal(SIGTERM);
  lab.server->Exit(30.0);
  lab.StartServer();
  findings.push_back(Resumes(lab));
  findings.push_back(LoopRuns(lab));
  findings.push_back(lab.JudgeTheHand());
  lab.server->Signal(SIGTERM);
  lab.server->Exit(30.0);
  return findings;
}

Findings NoMemory(int domain) {
  Lab lab(domain);
  Findings findings;
  for (const char* kilobytes : {"150000", "300000", "900000"}) {
    Finding finding{fmt::format("with {} kB it serves, or says what it lacks", kilobytes),
                    "it serves", true};
    try {
      lab.StartServer(
          {"--scene", "bunny-bunny"},
          {"/bin/sh", "-c", std::string("ulimit -v ") + kilobytes + "; exec \"$0\" \"$@\""});
    } catch (const Error& error) {
      // A program that is killed or aborts does not say that memory is missing.
      const std::string said = error.what();
      finding.held = said.find("out of memory") != std::string::npos;
      finding.found = finding.held ? "it says that it is out of memory" : said;
    }
    findings.push_back(finding);
    lab.server.reset();
  }
  return findings;
}

Findings HostileSamples(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartGateway();
  lab.StartRecorder();
  lab.StartStation();
  Wait(1.0);
  const std::uint64_t samples = FloodDomain(domain, 7, 5.0);
  Findings findings{Lives("the server", *lab.server), Lives("the gateway", *lab.gateway),
                    Lives("the recorder", *lab.recorder), LoopRuns(lab)};
  findings.back().found += fmt::format(", after {} samples", samples);
  const bool forged = lab.server->Output().find('\x1b') != std::string::npos;
  findings.push_back(
      {"no control character reaches the terminal", forged ? "one does" : "none does", !forged});
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

/// Returns a program's memory [MB].
double MemoryOf(const test::Program& program) {
  std::ifstream statm("/proc/" + std::to_string(program.id()) + "/statm");
  double pages = 0.0;
  statm >> pages >> pages;  // all of it, then what is resident
  return 1e-6 * pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

Findings ForgedCuts(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  lab.StartGateway();
  lab.StartRecorder();
  Wait(2.0);
  const double gateway = MemoryOf(*lab.gateway), recorder = MemoryOf(*lab.recorder),
               server = MemoryOf(*lab.server);
  const auto bytes = [&] { return static_cast<double>(fs::file_size(lab.recording())); };
  const double begun = bytes();
  const std::uint64_t samples = FloodNewKeys(domain, 5.0);
  Findings findings{LoopRuns(lab)};
  const auto grows = [&](const std::string& what, double before, double now, double most) {
    findings.push_back(
        {fmt::format("{} grows by {} MB at most", what, most),
         fmt::format("{:.1f} MB, then {:.1f}, after {} samples in 5 s", before, now, samples),
         now - before <= most});
  };
  grows("the gateway", gateway, MemoryOf(*lab.gateway), 25.0);
  grows("the recorder", recorder, MemoryOf(*lab.recorder), 25.0);
  grows("the server", server, MemoryOf(*lab.server), 25.0);
  grows("the recording", 1e-6 * begun, 1e-6 * bytes(), 2.0);
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

Findings HostilePort(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  lab.StartGateway();
  const std::string before = lab.station->Output();
  const std::uint64_t connections = FloodPort(lab.port(), 7, 5.0);
  Finding answers{"the gateway answers", "", !lab.Get("/healthz").empty()};
  answers.found = fmt::format("after {} connections", connections);
  return {answers, Undisturbed(lab, before), lab.JudgeTheHand()};
}

Findings SlowLorisAtThePort(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartGateway();
  SlowLoris loris(lab.port(), 500);
  int answered = 0;
  for (int i = 0; i < 20; ++i) {
    loris.Go();
    answered += !lab.Get("/healthz").empty();
    Wait(0.1);
  }
  return {{"newcomers are answered beside 500 that never end their request",
           fmt::format("{} of 20", answered), answered == 20}};
}

Findings SceneSwapped(int domain) {
  Lab lab(domain);
  const fs::path scene = lab.folder() / "own.json";
  fs::copy(PALPATE_SOURCE_DIR "/scenes/catalogue/cube.json", scene);
  lab.StartServer({"--scene", scene});
  lab.StartStation({"--scene", "own"});
  Wait(1.0);
  const std::string before = lab.station->Output();
  std::ofstream(scene) << "{ this is no scene";
  Wait(1.0);
  const auto other = lab.AnotherStation("late", "own");
  return {Undisturbed(lab, before), Lives("the server", *lab.server),
          Says("who comes later is told of the scene as it is served", *other, "driven by"),
          lab.JudgeTheHand()};
}

Findings TwoServers(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  const std::string before = lab.station->Output();
  test::Program second(
      test::OwnFolder() + "/palpate-server",
      {"cube", "--realtime", "off", "--transport", "udp", "--domain", std::to_string(domain)});
  const int exit = second.Exit(60.0);
  Wait(1.5);
  return {{"the second says that the domain is taken", fmt::format("exit status {}", exit),
           exit == 1 && second.Output().find("is in use by") != std::string::npos},
          Undisturbed(lab, before),
          lab.JudgeTheHand()};
}

Findings TwoRouDis(int domain) {
  Findings findings;
  if (OwnRouDi(findings) == nullptr) return findings;
  Lab lab(domain, "auto");
  lab.StartServer();
  lab.StartStation();
  const std::string before = lab.station->Output();
  test::Program second = AnotherRouDi();
  findings.push_back(Says("the second says that one runs", second, "is RouDi still running"));
  Wait(1.0);
  findings.push_back(Undisturbed(lab, before));
  findings.push_back(LoopRuns(lab));
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

}  // namespace

const std::vector<Fault>& AllFaults() {
  static const std::vector<Fault> faults = {
      {"server-killed", "kill -9 of the server, and a new one", ServerKilled},
      {"server-frozen", "SIGSTOP of the server for 5 s", ServerFrozen},
      {"station-killed", "kill -9 of a station", StationKilled},
      {"station-frozen", "SIGSTOP of a station for 4 s", StationFrozen},
      {"gateway", "SIGSTOP and kill -9 of the gateway, and a new one", GatewayKilledAndFrozen},
      {"gateway-blinded", "samples of other runs", GatewayBlinded},
      {"recorder-killed", "kill -9 of the recorder, six times", RecorderKilled},
      {"recorder-frozen", "SIGSTOP of the recorder for 4 s", RecorderFrozen},
      {"disk-full", "a disk of 640 kB for the recording", DiskFull},
      {"shm-small", "a /dev/shm that is full before anything starts", SharedMemoryTooSmall},
      {"shm-fills", "a /dev/shm of its own that fills up under running programs",
       SharedMemoryFills},
      {"clock-steps", "the wall clock of each program an hour ahead and back", ClockSteps},
      {"no-memory", "a server that may have little memory", NoMemory},
      {"hostile-samples", "samples with anything in them on every topic", HostileSamples},
      {"forged-cuts", "thousands of blocks, tools, stations and replays that are none", ForgedCuts},
      {"hostile-port", "anything at the gateway's port", HostilePort},
      {"slow-loris", "500 requests that never end", SlowLorisAtThePort},
      {"scene-swapped", "the scene's file overwritten under the server", SceneSwapped},
      {"two-servers", "a second server in the domain", TwoServers},
      {"two-roudis", "a second RouDi", TwoRouDis},
      {"roudi-killed", "kill -9 of RouDi, and a new one with a new server", RouDiKilled},
  };
  return faults;
}

std::vector<Finding> RandomFaults(int domain, std::uint64_t seed, int rounds) {
  Random random(seed);
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  lab.StartGateway();
  std::string done;
  for (int i = 0; i < rounds; ++i) {
    Wait(random.Uniform(0.2, 1.5));
    switch (random.Below(5)) {
      case 0:
        done += " kill-server";
        lab.server->Signal(SIGKILL);
        Wait(random.Uniform(0.0, 1.0));
        lab.StartServer();
        break;
      case 1:
        done += " freeze-server";
        Freeze(*lab.server, random.Uniform(0.01, 4.0));
        break;
      case 2:
        done += " freeze-station";
        Freeze(*lab.station, random.Uniform(0.01, 2.0));
        break;
      case 3:
        done += " kill-gateway";
        lab.gateway->Signal(SIGKILL);
        lab.gateway->Exit();
        lab.StartGateway();
        break;
      default:
        done += " flood";
        FloodDomain(domain, random.Bits(), random.Uniform(0.1, 1.0));
        break;
    }
    lab.station->Output();
    lab.gateway->Output();
    lab.server->Output();
  }
  Findings findings{LoopRuns(lab), Lives("the server", *lab.server),
                    Lives("the gateway", *lab.gateway)};
  findings.front().found += "; seed " + std::to_string(seed) + ":" + done;
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

}  // namespace palpate::faults
