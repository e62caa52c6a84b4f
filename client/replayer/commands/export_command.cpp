#include "client/replayer/commands/commands.h"
#include "common/program/stop_signal.h"

namespace palpate {
namespace {

constexpr const char* kExportExamples =
    R"(Examples:
  palpate-replay export lesson.mcap -o figures
      figures/hand_.../poses.csv and so on, for pandas.read_csv or MATLAB's
      readtable, and METHODS.md
  palpate-replay export lesson.mcap -o arrays --format npy
      for numpy.load
  palpate-replay export lesson.mcap -o cavity --solids --at 20
      what the burs had left after 20 s: cavity/tooth.stl, tooth.ply, and
      caries.palpate, which 'palpate-server ./cavity/caries.palpate' serves)";

}  // namespace

CommandLine ExportCommand::AddTo(const CommandLine& app) {
  const CommandLine line =
      app.AddCommand("export",
                     "export a recording as columns for figures, or what burs left as meshes\n"
                     "Columns are poses, wrenches, contacts and the limiter's interventions;\n"
                     "METHODS.md has the text for a paper's methods section.");
  line.Footer(kExportExamples);
  line.Add("files", columns.files, "a recording, or its split files in order").Required();
  line.Add("-o,--output", columns.folder, "folder to create").Required();
  const Option solids_option = line.AddFlag(
      "--solids", exports_solids, "export what burs left instead, as STL, PLY and a scene");
  line.AddText(
          "--format", [this](const std::string& text) { columns.format = ParseColumnFormat(text); },
          "csv, or npy: NumPy arrays with named fields")
      .Excludes(solids_option)
      .ShowDefault("csv");
  line.Add("--at", solids.at_s,
           "with --solids: time of the recording, in seconds; default: its end")
      .NotNegative()
      .Needs(solids_option);
  line.Add("--models", solids.models_dir, "with --solids: folder of meshes, as with --verify")
      .Needs(solids_option);
  return line;
}

void ExportCommand::Check() {
  solids.files = columns.files;
  solids.folder = columns.folder;
}

int ExportCommand::Run() const {
  StopSignal stop;
  if (exports_solids) {
    ExportSolids(solids, stop);
  } else {
    Export(columns, stop);
  }
  return 0;
}

}  // namespace palpate
