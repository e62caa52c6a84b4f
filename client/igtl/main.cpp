#include <chrono>
#include <cstdio>
#include <map>
#include <string>

#include "client/igtl/igtl_messages.h"
#include "client/igtl/igtl_server.h"
#include "client/igtl/options.h"
#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

/// As many as a server admits.
constexpr std::size_t kMostStations = 32;

std::int64_t SystemNanoseconds() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Sends each station's newest state, where there is a new one.
void Serve(const IgtlOptions& options, StopSignal& stop) {
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
      server.Send(IgtlMessages(state, SystemNanoseconds()), now_ns);
    }
  }
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-igtl", [&] {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-igtl", options->log_level);
    palpate::StopSignal stop;
    palpate::Serve(*options, stop);
    return 0;
  });
}
