#include "client/recorder/options.h"

#include <filesystem>

#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Records all that a palpate-server and its stations say, every pose and wrench included, as an
MCAP file: for palpate-replay, Foxglove and every other reader of MCAP.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-record -o lesson.mcap
      until Ctrl-C; start it before the stations, so that their first poses are in it
  palpate-record -o day.mcap --split-time 600
      a file for each ten minutes: day_000.mcap, day_001.mcap, ...
  palpate-record -o anna.mcap --station anna
      one hand of a class, as palpate-replay score wants it
  palpate-record info lesson.mcap
      what is in it, and whether anything is missing
  palpate-record -o far.mcap --network eth0
      of a server on another host, which runs with --network too

What was recorded a second ago is on the disk, even if this program or the machine fails.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

constexpr const char* kInfoExamples =
    R"(Examples:
  palpate-record info lesson.mcap
  palpate-record info day_000.mcap day_001.mcap --json day.json
      a recording in several files, for a program

Exit status: 0 where the file is whole, or lacks only what its recorder never had; 1 where it is damaged,
cut off or cannot be read; 2 wrong usage.)";

}  // namespace

std::optional<RecorderOptions> ParseRecorderOptions(int argc, const char* const* argv) {
  RecorderOptions options;
  double split_mb = 0.0;
  bool no_loop = false, no_bundle = false;

  const CommandLine app(kAbout, "palpate-record", kExamples);
  app.Add("-o,--output", options.recording.file, "file to record to, FILE.mcap");
  app.AddFlag("--overwrite", options.recording.overwrite,
              "replace the file if it is a recording; splits are never replaced");
  app.Add("--split-size", split_mb, "begin a new file after this many MB").Positive();
  app.Add("--split-time", options.recording.split_s, "begin a new file after this many seconds")
      .Positive();
  app.Add("--for", options.seconds, "end after this many seconds; default: at Ctrl-C").Positive();
  app.Add("--await-scene", options.scene,
          "say 'recording to' only once this scene has been heard and will be in the file; for a "
          "program that starts the hand then");
  app.Add("--station", options.stations,
          "record only this station's hand and session; scenes, and what is cut of them, are "
          "always recorded.  May be given again.  Default: all stations")
      .TypeName("NAME")
      .OneAtATime()
      .Check([](const std::string& name) {
        return dds::IsStationName(name) ? "" : "'" + name + "' is no station's name, as its --id";
      });
  app.AddFlag("--no-loop", no_loop, "leave out poses and wrenches: record only what viewers see");
  app.AddFlag("--no-bundle", no_bundle,
              "leave out the scenes; a replay then takes them from the catalogue");
  AddTransportOption(app, options.transport);
  AddServerOptions(app, options);
  const CommandLine info =
      app.AddCommand("info", "say what is in a recording, and what is missing");
  info.Footer(kInfoExamples);
  info.Add("files", options.info_files, "a recording, or its splits in their order").Required();
  info.Add("--json", options.json, "write it as JSON to this file; - is stdout");

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (!info.given() && options.recording.file.empty()) {
    throw UsageError("-o FILE.mcap is missing; 'palpate-record --help' shows how");
  }
  if (!info.given() && std::filesystem::path(options.recording.file).extension() != ".mcap") {
    throw UsageError("-o " + options.recording.file +
                     ": a recording is MCAP, whatever its name; give a name that ends in .mcap.  "
                     "Of that, 'palpate-replay export' makes CSV");
  }
  options.recording.split_bytes = static_cast<std::uint64_t>(1e6 * split_mb);
  options.recording.bundles = !no_bundle;
  options.loop = !no_loop;
  return options;
}

}  // namespace palpate
