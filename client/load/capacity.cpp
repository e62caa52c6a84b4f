#include "client/load/capacity.h"

#include <algorithm>
#include <map>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"

namespace palpate {
namespace {

constexpr const char* kLegend =
    R"(Server, gateway, stations and viewers share this machine. *Late*: the wrench took over 1 ms, never
came, or the station could not send in its millisecond. *Lost*: frames that were due to a viewer and
did not come. Percentiles are p50 / p99 / p99.9. Cores used are those of the server / the gateway,
then of `palpate-load`, whose part other machines would bear. The load averages stood before the run:
what else the machine did, and the runs before.

)";

constexpr const char* kHeading =
    R"(| stations | viewers | rate [Hz] | late | round trip [µs] | frames | lost | frame age [ms] | server / gateway [cores] | load [cores] | machine busy | load averages |
|---|---|---|---|---|---|---|---|---|---|---|---|
)";

std::string Cores(const std::optional<ProcessUse>& use) {
  return use ? fmt::format("{:.2f}", use->cpu) : "-";
}

std::string Percentiles(const Histogram& histogram, double unit, int digits) {
  if (histogram.count() == 0) return "-";
  const auto at = [&](double q) { return unit * static_cast<double>(histogram.Quantile(q)); };
  return fmt::format("{:.{}f} / {:.{}f} / {:.{}f}", at(0.5), digits, at(0.99), digits, at(0.999),
                     digits);
}

}  // namespace

Capacity FindCapacity(std::size_t most, int attempts,
                      const std::function<bool(std::size_t n)>& holds) {
  const auto holds_once = [&](std::size_t n) {
    for (int i = 0; i < attempts; ++i) {
      if (holds(n)) return true;
    }
    return false;
  };
  Capacity capacity;
  for (std::size_t n = 1; capacity.holds < most && capacity.fails == 0; n *= 2) {
    n = std::min(n, most);
    (holds_once(n) ? capacity.holds : capacity.fails) = n;
  }
  while (capacity.fails > capacity.holds + 1) {
    const std::size_t middle = capacity.holds + (capacity.fails - capacity.holds) / 2;
    (holds_once(middle) ? capacity.holds : capacity.fails) = middle;
  }
  return capacity;
}

FoundLoad FindLoad(std::size_t most, int attempts,
                   const std::function<std::optional<LoadFigures>(std::size_t n)>& run) {
  FoundLoad found;
  // By number of n, as the last failed run may have held at its second attempt.
  std::map<std::size_t, LoadFigures> failed;
  std::size_t refused = SIZE_MAX;
  found.capacity = FindCapacity(most, attempts, [&](std::size_t n) {
    if (n >= refused) return false;
    try {
      const auto figures = run(n);
      if (!figures) return false;
      if (Holds(*figures)) {
        found.held = figures;
        return true;
      }
      failed.insert_or_assign(n, *figures);
    } catch (const Error& error) {
      // If a smaller load has run, server and gateway are there.
      if (!found.held) throw;
      refused = n;
      found.refusal = error.what();
    }
    return false;
  });
  if (found.capacity.fails == refused) return found;
  found.refusal.clear();
  const auto least = failed.find(found.capacity.fails);
  if (least != failed.end()) found.failed = least->second;
  return found;
}

std::string TableRow(const LoadFigures& f) {
  const bool stations = f.stations > 0;
  const std::string viewers =
      fmt::format("{}{}{}", f.viewers, f.stalled > 0 ? fmt::format(" + {} stalled", f.stalled) : "",
                  f.dds_viewers > 0 ? fmt::format(" + {} DDS", f.dds_viewers) : "");
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.2f} | {:.0f} % | {} |\n",
                     f.stations, viewers, stations ? fmt::format("{:.1f}", f.sum.hz()) : "-",
                     stations ? fmt::format("{:.3f} %", 100.0 * f.sum.late_fraction()) : "-",
                     Percentiles(f.sum.round_trip, 1e-3, 0),
                     f.viewers > 0 ? std::to_string(f.viewer_frames) : "-",
                     f.viewers > 0 ? std::to_string(f.lost) : "-",
                     Percentiles(f.frame_age, 1e-6, 1), Cores(f.server) + " / " + Cores(f.gateway),
                     f.self.cpu, 100.0 * f.machine_busy, f.load_averages);
}

std::string ToMarkdown(const CapacityReport& r) {
  std::string text = R"(# Capacity

How many stations and viewers a machine holds, as `palpate-load` measures it.

)";
  text += "```sh\n" + r.command + "\n```\n\n";
  text += "| | |\n|---|---|\n";
  text += "| processor | " + r.machine.cpu + " |\n";
  text += fmt::format("| cores | {} |\n", r.machine.cores);
  text += "| compiler | " + r.machine.compiler + " |\n";
  text += "| begun | " + r.time + " |\n";
  text += "| scene | " + r.scene + " |\n";
  if (!r.runs.empty()) text += "| transport | " + r.runs.front().transport + " |\n";
  text += "| real-time | " + r.realtime + " |\n\n";
  text += kLegend;
  text += kHeading;
  for (const LoadFigures& run : r.runs) text += TableRow(run);
  if (!r.limits.empty()) text += "\n## Limits\n\n";
  for (const std::string& limit : r.limits) text += "- " + limit + "\n";
  return text;
}

}  // namespace palpate
