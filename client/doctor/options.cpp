#include "client/doctor/options.h"

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "common/program/command_line.h"
#include "devices/device_factory.h"

namespace palpate::doctor {
namespace {

constexpr const char* kAbout =
    R"(Says whether this host can hold a haptic loop of 1 kHz, and what to change where it cannot: kernel,
rights, processor, shared memory, RouDi, network, a loop that it really runs, the device, and how late
a thread wakes up over some seconds.  It changes nothing.  Run it as the user that is to run server
and station, with the host's usual load beside.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-doctor
  palpate-doctor --device openhaptics --transport shm --seconds 60
      on the host of an arm, which must have shared memory
  palpate-doctor --json | jq -r '.findings[] | select(.status != "ok") | .remedy'

Exit status: 0 fit (there may be warnings), 1 not fit, 2 wrong usage.)";

}  // namespace

std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  CLI::App app(kAbout, "palpate-doctor");
  app.footer(kExamples);
  app.add_option("--seconds", options.seconds,
                 "seconds for which to measure how late a loop wakes up; 0: do not measure")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--device", options.device,
                 "device that a station on this host is to drive: " + DeviceNames())
      ->type_name("NAME");
  app.add_option_function<std::string>(
         "--transport",
         [&options](const std::string& text) { options.transport = dds::ParseTransport(text); },
         "transport of server and station: shm, udp, or auto (shared memory if possible)")
      ->default_str("auto");
  app.add_flag("--json", options.json, "print one JSON object in place of the report");
  AddNetworkOptions(app, "the other host", options.network);
  AddRealtimeOptions(app, "the loops that it tries", options.realtime);
  AddCommonOptions(app, "domain whose ports are checked, and in which the loop is tried",
                   options.domain, options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (!options.device.empty())
    DeviceNeedsScript(options.device);  // refuses a name that there is not
  if (options.transport == dds::Transport::kSharedMemory && !options.network.this_host()) {
    throw UsageError("--transport shm joins programs of one host; leave --network out");
  }
  return options;
}

}  // namespace palpate::doctor
