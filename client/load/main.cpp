#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/load/load_figures.h"
#include "client/load/load_run.h"
#include "client/load/scene_copies.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// Shows progress: on a terminal, a line on stderr that the next one replaces; otherwise, for a
/// log, only every tenth second of a measurement.
void ShowProgress(const std::string& line) {
  static int lines = 0;
  if (isatty(STDERR_FILENO) == 1) {
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
  } else if (!line.empty() && line.find(" viewers: ") != std::string::npos && lines++ % 10 == 0) {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  std::fflush(stderr);
}

/// Returns the hand's path for each tool: the given one, the server's, or none, and the tool stays
/// at its start.
std::vector<PoseScript> ScriptsOf(const LoadRunOptions& options,
                                  const std::vector<OfferedTool>& tools) {
  std::optional<PoseScript> given;
  if (!options.script.empty()) given = PoseScript::Load(options.script);
  std::vector<PoseScript> scripts;
  for (const OfferedTool& tool : tools) {
    const std::optional<PoseScript>& hand = given ? given : tool.hand;
    if (!hand) spdlog::warn("{}: the hand stays where it starts; give --script", tool.remark);
    scripts.push_back(hand ? *hand : PoseScript({{0.0, tool.X_WT, "hold"}}));
  }
  return scripts;
}

/// Prints where a program that reads the JSON from standard output does not see it.
void Say(const LoadRunOptions& options, const std::string& text) {
  ShowProgress("");
  std::FILE* const out = options.json == "-" ? stderr : stdout;
  std::fputs(text.c_str(), out);
  std::fflush(out);
}

void Write(const LoadRunOptions& options, const std::vector<LoadFigures>& runs) {
  if (options.json.empty()) return;
  std::string text;
  for (const LoadFigures& run : runs) text += (text.empty() ? "" : ",") + ToJson(run);
  WriteOutput("--json", options.json, runs.size() == 1 ? text : "[" + text + "]\n");
}

/// Runs each number of stations with each of viewers, or as many as there is time for.
void RunGrid(const LoadSetting& setting, StopSignal& stop, std::vector<LoadFigures>& runs) {
  for (const std::size_t stations : setting.options.stations) {
    for (const std::size_t viewers : setting.options.viewers) {
      if (stop.stopped()) return;
      const auto figures = RunOnce(setting, {stations, viewers, setting.options.seconds}, stop);
      if (!figures) continue;
      Say(setting.options, ToText(*figures));
      runs.push_back(*figures);
    }
  }
}

/// Does what the options ask for, until it is complete or a signal comes.  Throws Error.
int RunLoad(const LoadRunOptions& options) {
  StopSignal stop;
  if (options.copies > 0) {
    WriteSceneWithCopies(options.scene.empty() ? "cube" : options.scene, options.copies,
                         options.copies_file);
    std::printf("%s: %zu tools; serve it with: palpate-server --scene %s\n",
                Printable(options.copies_file).c_str(), options.copies,
                ShellWord(options.copies_file).c_str());
    return 0;
  }
  // Checked before the runs, which may take hours.
  if (!options.json.empty()) CheckOutput("--json", options.json);
  const std::size_t stations = *std::ranges::max_element(options.stations);
  LoadSetting setting{options, {}, {}, ShowProgress};
  // Kept open, so that the domain is not created anew for each run.
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  if (stations > 0) {
    setting.tools = AskForTools(service, {options.domain, options.network, options.patience_s},
                                options.scene, stop);
    if (stop.stopped()) return 0;
    setting.scripts = ScriptsOf(options, setting.tools);
    if (stations > setting.tools.size()) {
      throw Error(fmt::format(
          "--stations {}: the server offers {} tools, and each is one station's alone; start "
          "palpate-server with a scene that 'palpate-load --make-scene {} FILE' makes",
          stations, setting.tools.size(), stations));
    }
  }
  std::vector<LoadFigures> runs;
  try {
    RunGrid(setting, stop, runs);
  } catch (const std::exception&) {
    if (!runs.empty()) Write(options, runs);
    throw;
  }
  Write(options, runs);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-load", argc, argv, palpate::ParseLoadOptions,
                             palpate::RunLoad);
}
