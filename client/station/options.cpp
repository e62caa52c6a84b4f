#include "client/station/options.h"

#include <filesystem>

#include "client/station/guide.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Drives a haptic device in a scene of a palpate-server.  A thousand times a
second it sends the pose of the hand and applies the wrench that the server
returns.  Shows a live table, and prints a summary at the end.
)";

constexpr const char* kExamples = R"(
Examples:
  palpate-server --scene bunny-bunny &
  palpate-station --device simulated --scene bunny-bunny --id hand --loop
      a simulated hand and arm feel the bunny until Ctrl-C
  palpate-station --device scripted --scene cube --id probe --for 10 \
                  --json run.json
      plays the scene's script exactly for 10 s; writes the figures as JSON
  palpate-station --device simulated --model touch --scale 2 --scene cube --id s
      an arm without torque.  The tool moves 2 mm for each millimetre of the
      hand: a spring of 1 N/mm is felt as 2 N/mm; forces are those of the scene,
      torques are halved
  palpate-station --device spacemouse --clutch-button 1 --scene cube --id me
      a SpaceMouse, through spacenavd.  While its second button is pressed, the
      hand moves and the tool does not
  palpate-station --device mouse --scene cube --id me < targets
      no device: each line of standard input, 'x y z qw qx qy qz' in metres and
      in the scene's frame, drags the tool there, smoothly and at most 20 mm
      deep; 'release' lets go of it; the end of input ends the station
  palpate-station --device openhaptics --scene cube --id me
      a PHANTOM or Touch arm, through the installed OpenHaptics library or the
      file named by PALPATE_OPENHAPTICS_LIBRARY
  palpate-station --device forcedimension --device-name 4711 --scene cube --id m
      the omega, delta, sigma or lambda with this serial number, through
      libdhd.so.3 or the file named by PALPATE_FORCEDIMENSION_LIBRARY
  palpate-station --device haply --scene cube --id me
      an Inverse3 with VerseGrip, through the Inverse Service at
      ws://localhost:10001 or the address in PALPATE_HAPLY_SERVICE
  palpate-station --device ./mine.so --scene cube --id me
      an arm of your own, by a driver built against palpate_device.h (see 'An
      arm of your own' in devices/arm.md); test the driver first with
      'palpate-doctor --device ./mine.so'
  palpate-station --device simulated --scene cube --id far --network eth0
      connects to a server on another host, also started with --network

A real device renders forces only while its first button is pressed, or always
with --enable-forces; they are off within 50 ms of its release.  Forces fade to
zero within 25 ms after the server stops answering, and ramp up again when it
answers.
Exit status: 0 done, 1 failed or refused, 2 wrong usage.)";

void AddDeviceOptions(const CommandLine& app, StationOptions& options) {
  app.Add("--device", options.device.name, "device to drive: " + DeviceNames()).Required();
  app.Add("--model", options.device.model, "arm to simulate; default: the first one listed below");
  app.Add("--rate", options.device.rate_Hz, "rate at which the device is read and commanded, in Hz")
      .ShowDefault();
  app.Add("--device-name", options.device.arm,
          "arm to use if there are several: its name in the vendor's set-up program, its serial "
          "number, or its id; default: the first");
  app.AddFlag("--calibrate", options.device.calibrate,
              "calibrate the arm even if it is already calibrated; if it has a reset position, put "
              "it there first");
  app.AddFlag("--loop", options.device.loop,
              "repeat the script; otherwise the hand stays at its end");
}

void AddSceneOptions(const CommandLine& app, StationOptions& options) {
  app.Add("--scene", options.link.scene,
          "scene to feel: its name on the server, or the file given to the server")
      .Required();
  app.Add("--tool", options.link.tool, "tool of the scene; required if the scene has several");
  app.Add("--id", options.link.station, "name of this station: 1 to 32 letters, digits or _")
      .Required();
  app.Add("--script", options.script,
          "path of the simulated hand (JSON); default: the server's script for the scene, which it "
          "generates if there is none");
  app.Add("--workspace", options.workspace,
          "file that maps the device to the scene (JSON): calibration, frame, scale, clutch, "
          "walls");
  app.Add("--scale", options.scale,
          "motion of the tool per motion of the hand; default: that of --workspace, else 1")
      .Range(Workspace::kLeastScale, Workspace::kMostScale);
  app.Add("--clutch-button", options.clutch_button,
          "button, counted from 0, that lets the hand move without the tool")
      .Range(0, 31);
  app.AddFlag("--await-recorder", options.link.awaits_recorder,
              "send no pose before a palpate-record reads the poses and the server's answers, so "
              "that the recording is complete and can be verified");
  app.AddFlag(
      "--keep-scene", options.link.keeps_scene,
      "nobody can restore a cut scene, or set its bookmark, while this station has its tool: "
      "for trials");
}

void AddForceOptions(const CommandLine& app, StationOptions& options) {
  app.AddFlag("--enable-forces", options.enable_forces,
              "let a real device render forces all the time, not only while its first button is "
              "pressed; simulated devices always do");
  app.Add("--max-force", options.max_force_N,
          "limit of the force, in N, below the device's own; the limit of the torque is reduced "
          "in proportion; default: the device's limits")
      .Positive();
  const Option accept_guide = app.AddFlag("--accept-guide", options.accept_guide,
                                          "let 'palpate-replay --guide ID' guide the hand");
  app.Add("--guide-force", options.guide_force_N,
          "limit of the guiding force, in N; that of the torque, in N m, is a hundredth of it")
      .Range(0.0, GuideLimits::kMostForce_N)
      .Needs(accept_guide)
      .ShowDefault();
}

}  // namespace

std::optional<StationOptions> ParseStationOptions(int argc, const char* const* argv) {
  StationOptions options;
  bool table = false;
  std::string local_model = "on";

  const CommandLine app(kAbout, "palpate-station", "Devices:\n" + DeviceHelp() + kExamples);
  AddDeviceOptions(app, options);
  AddSceneOptions(app, options);
  AddForceOptions(app, options);
  app.Add("--local-model", local_model,
          "on: evaluate each reply's contacts at the newest pose, and send predicted poses if the "
          "round trip takes more than 2 ms; off: apply each wrench unchanged")
      .OneOf({"on", "off"})
      .ShowDefault();
  app.Add("--for", options.seconds, "end after this many seconds; default: at Ctrl-C").Positive();
  AddTransportOption(app, options.link.transport);
  AddNetworkOptions(app, "the server", options.link.network);
  app.Add("--wait", options.link.patience_s,
          "how long to wait for the server's first answer, in seconds")
      .Positive()
      .ShowDefault();
  AddRealtimeOptions(app, "the loop", options.link.realtime);
  const Option has_table =
      app.AddFlag("--table,!--no-table", table,
                  "show a live table, or one line per second; default: a table on a terminal");
  app.Add("--json", options.json, "write the summary as JSON to this file; -: standard output");
  app.Add("--trace", options.trace,
          "write one row per tick to this file (CSV): replies, their age, forces");
  AddCommonOptions(app, "number of the domain: the same as the server's", options.link.domain,
                   options.log_level);

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (!dds::IsStationName(options.link.station)) {
    throw UsageError("--id '" + options.link.station + "': give 1 to 32 letters, digits or _");
  }
  if (has_table.given()) options.table = table;
  options.local_model = local_model == "on";
  options.link.device = std::filesystem::path(options.device.name).filename();
  options.device.realtime = options.link.realtime;
  CheckDevice(options.device.name, options.device.model, options.device.rate_Hz);
  return options;
}

}  // namespace palpate
