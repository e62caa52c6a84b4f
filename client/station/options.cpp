#include "client/station/options.h"

#include <filesystem>

#include "client/station/guide.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Drives a haptic device in a scene that a palpate-server holds: a pose out and a wrench back, a
thousand times a second.  Shows live what happens, and a summary at the end.
)";

constexpr const char* kExamples = R"(
Examples:
  palpate-server --scene bunny-bunny &
  palpate-station --device simulated --scene bunny-bunny --id hand --loop
      a simulated arm and hand feel the bunny until Ctrl-C
  palpate-station --device scripted --scene cube --id probe --for 10 --json run.json
      the scene's script, played exactly for 10 s, with figures for a program
  palpate-station --device simulated --model touch --scale 2 --scene cube --id small
      an arm that renders no torque; each millimetre of the hand moves the tool by two: a spring
      of 1 N/mm is felt as 2 N/mm, force stays as the scene has it, torque is halved
  palpate-station --device spacemouse --clutch-button 1 --scene cube --id me
      a SpaceMouse, through spacenavd; while its second button is down, the hand moves and the
      tool does not
  palpate-station --device mouse --scene cube --id me < targets
      a hand without a device: each line on standard input, 'x y z qw qx qy qz' in metres and
      the scene's frame, drags the tool there, smoothly and pressing at most 20 mm deep;
      'release' lets it go; the end of input ends the station
  palpate-station --device openhaptics --scene cube --id me
      a PHANTOM or Touch arm, through the OpenHaptics library that is installed, or the file that
      PALPATE_OPENHAPTICS_LIBRARY names
  palpate-station --device forcedimension --device-name 4711 --scene cube --id me
      the omega, delta, sigma or lambda with that serial number, through libdhd.so.3, or the file
      that PALPATE_FORCEDIMENSION_LIBRARY names
  palpate-station --device haply --scene cube --id me
      an Inverse3 with its VerseGrip, through the Inverse Service at ws://localhost:10001, or the
      address that PALPATE_HAPLY_SERVICE names
  palpate-station --device ./mine.so --scene cube --id me
      an arm of your own, by a driver that you have built against palpate_device.h ('An arm of your
      own' in devices/arm.md); 'palpate-doctor --device ./mine.so' tries it first
  palpate-station --device simulated --scene cube --id far --network eth0
      a server on another host, which runs with --network too

Forces reach a real device only while its first button is held, or all the time with
--enable-forces; letting the button go takes them away within 50 ms.  They fade to zero within
25 ms when the server stops answering, and ramp in again when it is back.
Exit status: 0 done, 1 failed or refused, 2 wrong usage.)";

}  // namespace

std::optional<StationOptions> ParseStationOptions(int argc, const char* const* argv) {
  StationOptions options;
  bool table = false;
  std::string local_model = "on";

  const CommandLine app(kAbout, "palpate-station", "Devices:\n" + DeviceHelp() + kExamples);
  app.Add("--device", options.device.name, "the device: " + DeviceNames()).Required();
  app.Add("--model", options.device.model,
          "which arm to simulate; default: the first that is named below");
  app.Add("--rate", options.device.rate_Hz, "how often the device is read and commanded, in Hz")
      .ShowDefault();
  app.Add("--scene", options.link.scene,
          "scene to feel: its name at the server, or the file that the server was given")
      .Required();
  app.Add("--tool", options.link.tool, "tool of the scene; needed only if the scene has several");
  app.Add("--id", options.link.station, "name of this station: 1 to 32 letters, digits or _")
      .Required();
  app.Add("--script", options.script,
          "poses that the simulated hand follows (JSON); default: the script that the server has "
          "for the scene, or makes for it");
  app.Add("--workspace", options.workspace,
          "file that says how the device lies in the scene (JSON): calibration, frame, scale, "
          "clutch, walls");
  app.Add("--scale", options.scale,
          "millimetres that the tool moves for each millimetre of the hand; default: the "
          "workspace's, else 1")
      .Range(Workspace::kLeastScale, Workspace::kMostScale);
  app.Add("--clutch-button", options.clutch_button,
          "button that lets the hand move without the tool, a number from 0")
      .Range(0, 31);
  app.AddFlag("--loop", options.device.loop,
              "repeat the script; without it the hand stays at the script's end");
  app.AddFlag("--enable-forces", options.enable_forces,
              "let forces out to a real device all the time, not only while its first button is "
              "held; simulated devices always get them");
  app.AddFlag("--await-recorder", options.link.awaits_recorder,
              "send no pose before a palpate-record reads it, for up to 3 s, so that the recording "
              "has the first and can be verified");
  app.Add("--max-force", options.max_force_N,
          "greatest force, in N, where that is less than the device's own; its torque goes down by "
          "the same share; default: the device's own")
      .Positive();
  app.Add("--device-name", options.device.arm,
          "which arm, if there are several: its name in the vendor's set-up program, its serial "
          "number, or its id; default: the first");
  app.AddFlag("--calibrate", options.device.calibrate,
              "calibrate the arm even if it is calibrated; put it into its reset position first, "
              "if it has one");
  app.Add("--local-model", local_model,
          "on: compute the force of a reply's contacts at the newest pose, and ask ahead where the "
          "server is more than 2 ms away; off: apply each wrench as it came")
      .OneOf({"on", "off"})
      .ShowDefault();
  const Option accept_guide = app.AddFlag("--accept-guide", options.accept_guide,
                                          "let 'palpate-replay --guide ID' lead the hand gently");
  app.Add("--guide-force", options.guide_force_N,
          "greatest force of a guide, in N; its greatest torque, in N m, is a hundredth of that")
      .Range(0.0, GuideLimits::kMostForce_N)
      .Needs(accept_guide)
      .ShowDefault();
  app.Add("--for", options.seconds, "end after this many seconds; default: at Ctrl-C").Positive();
  AddTransportOption(app, options.link.transport);
  AddNetworkOptions(app, "the server", options.link.network);
  app.Add("--wait", options.link.patience_s, "seconds to wait for the server's first answer")
      .Positive()
      .ShowDefault();
  AddRealtimeOptions(app, "the loop", options.link.realtime);
  const Option has_table =
      app.AddFlag("--table,!--no-table", table,
                  "show a live table, or else a line a second; default: a table on a terminal");
  app.Add("--json", options.json, "write the summary as JSON to this file; - is stdout");
  app.Add("--trace", options.trace,
          "write a row for every tick to this file (CSV): replies, their age, forces");
  AddCommonOptions(app, "the server's domain: the number after its --domain", options.link.domain,
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
