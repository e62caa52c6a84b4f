#include <chrono>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include "client/igtl/igtl_messages.h"
#include "client/igtl/igtl_server.h"
#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/wall_clock.h"

namespace palpate {
namespace {

/// As many stations as a server admits.
constexpr std::size_t kMostStations = 32;

constexpr const char* kAbout =
    R"(Sends the poses and forces of all tools to 3D Slicer and others by OpenIGTLink.
For each station: a TRANSFORM (millimetres, RAS), and the SENSORs STATION_force
(N) and STATION_torque (N m).
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-igtl
      then, in 3D Slicer: SlicerOpenIGTLink, a connector of type client to
      localhost, port 18944
  palpate-igtl --bind 0.0.0.0 --rate 30
      for other hosts, 30 times a second

The axes of a scene (x left, y up, z forward) are converted to RAS.  Messages
from clients are ignored.  A slow client gets fewer messages; one that receives
nothing for 10 s is disconnected.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

struct Options : ServerOptions {
  std::string address = "127.0.0.1";
  int port = 18944;
  double rate_Hz = 60.0;
};

/// Returns nothing after --help or --version.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  const CommandLine app(kAbout, "palpate-igtl", kExamples);
  app.Add("--bind", options.address, "address of this host to listen on").ShowDefault();
  app.Add("--port", options.port, "TCP port; 0: any free port, which is printed")
      .Range(0, 65535)
      .ShowDefault();
  app.Add("--rate", options.rate_Hz, "messages per second; the server sends 60 updates per second")
      .Range(0.1, 1000.0)
      .ShowDefault();
  AddServerOptions(app, options);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  return options;
}

/// Sends each station's newest state, if it is new.
int Serve(const Options& options) {
  StopSignal stop;
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  dds::Reader<wire::ToolState> states(service, dds::kToolStateTopic, dds::Qos::kRecord);
  IgtlServer server(options.address, options.port);
  std::printf("ready: OpenIGTLink at %s:%d\n", options.address.c_str(), server.port());
  std::fflush(stdout);

  const std::chrono::nanoseconds period(static_cast<std::int64_t>(1e9 / options.rate_Hz));
  std::map<std::string, wire::ToolState> newest;
  while (!stop.WaitFor(period)) {
    newest.clear();
    for (wire::ToolState state; states.Take(state);) {
      if (!dds::IsStationName(state.station)) continue;
      if (newest.size() < kMostStations || newest.contains(state.station)) {
        newest[state.station] = state;
      }
    }
    const std::int64_t now_ns = SteadyNanoseconds();
    server.Poll(now_ns);
    for (const auto& [station, state] : newest) {
      server.Send(IgtlMessages(state, WallClock_ns()), now_ns);
    }
  }
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-igtl", argc, argv, palpate::ParseOptions, palpate::Serve);
}
