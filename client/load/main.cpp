#include <algorithm>
#include <cstdio>
#include <ctime>
#include <optional>
#include <utility>

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/load/capacity.h"
#include "client/load/load_run.h"
#include "client/load/scene_copies.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr double kFindSeconds = 3.0;
constexpr int kFindAttempts = 2;
constexpr std::size_t kMostViewers = 2000;

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

class Load {
 public:
  Load(const LoadRunOptions& options, LoadSetting setting, StopSignal& stop)
      : options_(options), setting_(std::move(setting)), stop_(stop) {
    report_.machine = ThisHost();
    report_.time = fmt::format("{:%F %R} UTC", fmt::gmtime(std::time(nullptr)));
    report_.command = options.command;
    report_.scene = setting_.tools.empty() ? "-" : setting_.tools.front().scene;
  }

  void RunGrid() {
    for (const std::size_t stations : options_.stations) {
      for (const std::size_t viewers : options_.viewers) {
        if (stop_.stopped()) return;
        Keep(Run({stations, viewers, options_.seconds}));
      }
    }
  }

  void Find() {
    const std::size_t tools = setting_.tools.size();
    Search("stations", "1 kHz and no viewers", tools,
           fmt::format("the server's scenes have {} tools; make a scene with more by --make-scene",
                       tools),
           [](std::size_t n) { return std::pair(n, std::size_t{0}); });
    if (stop_.stopped()) return;
    const std::size_t stations = options_.stations.front();
    try {
      Search("viewers", fmt::format("{:.0f} Hz beside {} stations", options_.rate_hz, stations),
             kMostViewers, "no more were tried",
             [stations](std::size_t n) { return std::pair(stations, n); });
    } catch (const Error& error) {
      Say(std::string("viewers are not searched for: ") + error.what() + "\n");
    }
  }

  /// Writes the figures of the runs before one that failed, if any.
  void WriteWhatThereIs() const {
    if (!report_.runs.empty()) Write();
  }
  void Write() const {
    if (!options_.json.empty()) WriteOutput("--json", options_.json, Json());
    if (!options_.report.empty()) WriteOutput("--report", options_.report, ToMarkdown(report_));
  }

 private:
  std::optional<LoadFigures> Run(const LoadSize& size) {
    return RunOnce(setting_, size, stop_, &report_.realtime);
  }

  void Keep(const std::optional<LoadFigures>& figures) {
    if (!figures) return;
    Say(ToText(*figures));
    report_.runs.push_back(*figures);
  }

  /// @param of  returns the stations and viewers of a run with n of the quantity that is searched.
  template <class Of>
  void Search(const std::string& what, const std::string& at, std::size_t most,
              const std::string& no_more, Of of) {
    const FoundLoad found =
        FindLoad(most, kFindAttempts, [&](std::size_t n) -> std::optional<LoadFigures> {
          if (stop_.stopped()) return std::nullopt;
          const auto [stations, viewers] = of(n);
          const auto figures = Run({stations, viewers, std::min(options_.seconds, kFindSeconds)});
          if (!figures || stop_.stopped()) return std::nullopt;
          Say(fmt::format("{} {}: {:.3f} % late, {:.1f} % of the frames lost: {}\n", n, what,
                          100.0 * figures->sum.late_fraction(), 100.0 * figures->lost_fraction(),
                          VerdictText(*figures)));
          return figures;
        });
    if (stop_.stopped()) return;
    const Capacity& capacity = found.capacity;
    if (found.held) report_.runs.push_back(*found.held);
    if (found.failed) report_.runs.push_back(*found.failed);
    std::string why = no_more;
    if (capacity.fails > 0) {
      why = found.failed ? LimitingResource(*found.failed, report_.machine.cores) : found.refusal;
    }
    const std::string limit = fmt::format(
        "{} {} at {}{}: {}", capacity.holds, what, at,
        capacity.fails > 0 ? fmt::format("; {} do not hold", capacity.fails) : std::string(" hold"),
        why);
    Say("limit: " + limit + "\n");
    report_.limits.push_back(limit);
  }

  std::string Json() const {
    if (report_.runs.size() == 1 && !options_.find) return ToJson(report_.runs.front());
    std::string text = "[";
    for (const LoadFigures& run : report_.runs) {
      if (text.size() > 1) text += ",";
      text += ToJson(run);
    }
    return text + "]\n";
  }

  void Say(const std::string& text) const {
    ShowProgress("");
    // If the JSON goes to standard output, a program reads that.
    std::FILE* const out = options_.json == "-" ? stderr : stdout;
    std::fputs(text.c_str(), out);
    std::fflush(out);
  }

  const LoadRunOptions& options_;
  LoadSetting setting_;
  StopSignal& stop_;
  CapacityReport report_;
};

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
  if (!options.report.empty()) CheckOutput("--report", options.report);
  const std::size_t stations = *std::ranges::max_element(options.stations);
  LoadSetting setting{options, {}, {}, ShowProgress};
  // Kept open, so that the domain is not created anew for each run.
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  if (stations > 0 || options.find) {
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
  Load load(options, std::move(setting), stop);
  try {
    if (!options.find || !options.report.empty()) load.RunGrid();
    if (options.find) load.Find();
  } catch (const std::exception&) {
    load.WriteWhatThereIs();
    throw;
  }
  load.Write();
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-load", argc, argv, palpate::ParseLoadOptions,
                             palpate::RunLoad);
}
