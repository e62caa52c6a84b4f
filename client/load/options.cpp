#include "client/load/options.h"

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/realtime.h"
#include "common/text/number_of.h"
#include "scenes/files/scene_file.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Load test of a running palpate-server and its palpate-viewer.
Simulates stations at 1 kHz, and viewers over WebSocket.  Reports the rate
and round trip that were reached, the late poses, what the viewers received, and
what each process cost.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-load --make-scene 32 /tmp/many.json
      a scene like 'cube', with 32 balls, since each station needs its own tool
  palpate-server --scene /tmp/many.json & palpate-viewer --http 8765 &
  palpate-load --scene /tmp/many.json --stations 8 --viewers 50 --json -
  palpate-load --scene /tmp/many.json --stations 1,4,16 --viewers 0,50,200
      all combinations; each says whether it holds
  palpate-load --stations 4 --network eth0
      a server on another host, also started with --network
  palpate-identities add lab load load
  palpate-load --stations 4 --identity lab/identities/load
      a secured domain: an identity of the role 'load', named like --name

A pose is late if its wrench takes more than 1 ms or never arrives, or if its
station could not send it in its millisecond.  CPU fractions are of one core.
Frames are tool states that a viewer received; their age is the time from the
station's sample to the viewer, on one host.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

}  // namespace

ViewerUrl ParseViewerUrl(const std::string& url) {
  const std::string scheme = "ws://";
  const auto wrong = [&] {
    return UsageError("--viewer-url '" + url +
                      "': give ws://HOST:PORT, such as ws://127.0.0.1:8765");
  };
  if (!url.starts_with(scheme)) throw wrong();
  std::string rest = url.substr(scheme.size());
  if (rest.ends_with('/')) rest.pop_back();
  const std::size_t colon = rest.rfind(':');
  if (colon == 0 || colon == std::string::npos) throw wrong();
  const int port = NumberOf<int>(rest.substr(colon + 1)).value_or(0);
  if (port < 1 || port > 65535) throw wrong();
  return {rest.substr(0, colon), port};
}

std::optional<LoadRunOptions> ParseLoadOptions(int argc, const char* const* argv) {
  LoadRunOptions options;
  std::string url = options.viewer_url.text();
  std::vector<std::string> make_scene;

  const CommandLine app(kAbout, "palpate-load", kExamples);
  app.Add("--stations", options.stations,
          "number of simulated stations; several numbers, such as 1,4,16, make one run each")
      .Commas()
      .Range(0, 1000)
      .ShowDefault();
  app.Add("--viewers", options.viewers,
          "number of viewers over WebSocket; several numbers as for --stations")
      .Commas()
      .Range(0, 10000)
      .ShowDefault();
  app.Add("--seconds", options.seconds, "duration of each run, after one second to warm up")
      .Range(0.5, 86400.0)
      .ShowDefault();
  app.Add("--viewer-url", url, "the gateway's WebSocket").ShowDefault();
  app.Add("--rate", options.rate_hz, "updates of each tool per second, as given to palpate-viewer")
      .Range(1.0, 60.0)
      .ShowDefault();
  app.Add("--scene", options.scene,
          "scene of the stations, by name or file; default: all scenes of the server");
  app.Add("--script", options.script,
          "path of the hands (JSON); default: the server's script for the scene");
  app.Add("--name", options.name, "prefix of the stations' names, which a number follows")
      .ShowDefault();
  AddTransportOption(app, options.transport);
  app.Add("--realtime", options.realtime,
          "real-time scheduling of the stations' loops: require, prefer or off")
      .ShowDefault();
  app.Add("--wait", options.patience_s, "how long to wait for server and gateway, in seconds")
      .Positive()
      .ShowDefault();
  app.Add("--json", options.json, "write the figures as JSON to this file; -: standard output");
  app.Add("--make-scene", make_scene,
          "N FILE: write a scene file like --scene (default: cube), but with N tools, and exit")
      .Words(2);
  AddEffectsOption(app);
  AddServerOptions(app, options);

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (!dds::IsStationName(options.name + "_1000")) {
    throw UsageError("--name '" + options.name + "': give 1 to 27 letters, digits or _");
  }
  if (!make_scene.empty()) {
    const std::string& n = make_scene[0];
    options.copies = NumberOf<std::size_t>(n).value_or(0);
    if (options.copies < 1 || options.copies > kMostBodies) {
      throw UsageError("--make-scene " + n + ": give a number of tools from 1 to " +
                       std::to_string(kMostBodies) + ", and a file");
    }
    options.copies_file = make_scene[1];
    if (!options.copies_file.ends_with(".json")) {
      throw UsageError("--make-scene: the file '" + options.copies_file +
                       "' must end in .json; programs recognise a scene file by that");
    }
  }
  options.viewer_url = ParseViewerUrl(url);
  ParseRealtimeMode(options.realtime);  // throws
  return options;
}

}  // namespace palpate
