#include "client/recorder/options.h"

#include <filesystem>

#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Records a palpate-server and its stations, with every pose and wrench, as an
MCAP file: for palpate-replay, Foxglove and other readers of MCAP.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-record -o lesson.mcap
      records until Ctrl-C; start it before the stations, so that it includes
      their first poses
  palpate-record -o day.mcap --split-time 600
      one file per ten minutes: day_000.mcap, day_001.mcap, ...
  palpate-record -o anna.mcap --station anna
      one hand of a class, for 'palpate-replay score'
  palpate-record info lesson.mcap
      what the recording contains, and whether anything is missing
  palpate-record -o far.mcap --network eth0
      records a server on another host, also started with --network

Data is on disk within a second, even if this program or the machine fails.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

constexpr const char* kInfoExamples =
    R"(Examples:
  palpate-record info lesson.mcap
  palpate-record info day_000.mcap day_001.mcap --json day.json
      a recording in several files, for a program

Exit status: 0 the file is complete, or lacks only what the recorder never
received; 1 it is damaged, truncated or cannot be read; 2 wrong usage.)";

}  // namespace

std::optional<RecorderOptions> ParseRecorderOptions(int argc, const char* const* argv) {
  RecorderOptions options;
  double split_mb = 0.0;
  bool no_loop = false, no_bundle = false;

  const CommandLine app(kAbout, "palpate-record", kExamples);
  app.Add("-o,--output", options.recording.file, "file to record to, FILE.mcap");
  app.AddFlag("--overwrite", options.recording.overwrite,
              "replace the file if it is a recording; split files are never replaced");
  app.Add("--split-size", split_mb, "start a new file after this many MB").Positive();
  app.Add("--split-time", options.recording.split_s, "start a new file after this many seconds")
      .Positive();
  app.Add("--for", options.seconds, "end after this many seconds; default: at Ctrl-C").Positive();
  app.Add(
      "--await-scene", options.scene,
      "print 'recording to' only after this scene has arrived, so that the file includes it; for "
      "a program that starts the hand afterwards");
  app.Add("--station", options.stations,
          "record only the hand and session of this station; scenes and cuts are always recorded.  "
          "Can be repeated.  Default: all stations")
      .TypeName("NAME")
      .OneAtATime()
      .Check([](const std::string& name) {
        return dds::IsStationName(name)
                   ? ""
                   : "'" + name + "' is not the name of a station; give its --id";
      });
  app.AddFlag("--no-loop", no_loop, "omit poses and wrenches: record only what viewers see");
  app.AddFlag("--no-bundle", no_bundle,
              "omit the scenes; a replay then takes them from the catalogue");
  AddTransportOption(app, options.transport);
  AddServerOptions(app, options);
  const CommandLine info =
      app.AddCommand("info", "show what a recording contains, and what is missing");
  info.Footer(kInfoExamples);
  info.Add("files", options.info_files, "a recording, or its split files in order").Required();
  info.Add("--json", options.json, "write the summary as JSON to this file; -: standard output");

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (!info.given() && options.recording.file.empty()) {
    throw UsageError("-o FILE.mcap is missing; 'palpate-record --help' shows how");
  }
  if (!info.given() && std::filesystem::path(options.recording.file).extension() != ".mcap") {
    throw UsageError(
        "-o " + options.recording.file +
        ": recordings are MCAP; give a name that ends in .mcap.  'palpate-replay export' "
        "makes CSV of it");
  }
  options.recording.split_bytes = static_cast<std::uint64_t>(1e6 * split_mb);
  options.recording.bundles = !no_bundle;
  options.loop = !no_loop;
  return options;
}

}  // namespace palpate
