#include "scenes/tree_error_table.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

/// What a level is: the last is felt; those above bound it.
const char* KindOf(const BodyTreeError& error, std::size_t level) {
  return level + 1 == error.levels.size() ? "leaves" : "bounds";
}

/// Every figure of a level with its name, in the order of the CSV's columns.
std::vector<std::pair<const char*, double>> FiguresOf(const UnionError& e) {
  return {{"offset_mean_m", e.offset.mean},         {"offset_rms_m", e.offset.rms},
          {"offset_min_m", e.offset.min},           {"offset_p1_m", e.offset.p1},
          {"offset_p50_m", e.offset.p50},           {"offset_p99_m", e.offset.p99},
          {"offset_max_m", e.offset.max},           {"tilt_mean_deg", kDegrees * e.tilt.mean},
          {"tilt_p99_deg", kDegrees * e.tilt.p99},  {"tilt_max_deg", kDegrees * e.tilt.max},
          {"protrusion_mean_m", e.protrusion.mean}, {"protrusion_max_m", e.protrusion.max},
          {"uncovered_share", e.uncovered_share},   {"missed_share", e.missed_share},
          {"volume_ratio", e.volume_ratio}};
}

template <class... Values>
std::string Format(const char* format, Values... values) {
  std::string line(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, values...)), '\0');
  std::snprintf(line.data(), line.size() + 1, format, values...);
  return line;
}

}  // namespace

std::string ToText(const BodyTreeError& error) {
  std::string text = Format(
      "  %s\n    %-13s %7s  %42s  %21s  %15s  %9s %7s\n"
      "    %-13s %7s  %8s %8s %8s %8s %6s  %6s %6s %7s  %7s %7s  %9s %7s\n",
      error.body.c_str(), "level", "spheres", "offset of the union, um", "tilt of the normal, deg",
      "protrusion, um", "uncovered", "volume", "", "", "mean", "rms", "p1", "p99", "max", "mean",
      "p99", "max", "mean", "max", "share", "ratio");
  for (std::size_t l = 0; l < error.levels.size(); ++l) {
    const UnionError& e = error.levels[l];
    text += Format(
        "    %zu, %-10s %7zu  %8.1f %8.1f %8.1f %8.1f %6.0f  %6.2f %6.2f %7.2f  %7.1f %7.1f  "
        "%9.4f %7.4f\n",
        l + 1, KindOf(error, l), e.spheres, 1e6 * e.offset.mean, 1e6 * e.offset.rms,
        1e6 * e.offset.p1, 1e6 * e.offset.p99, 1e6 * e.offset.max, kDegrees * e.tilt.mean,
        kDegrees * e.tilt.p99, kDegrees * e.tilt.max, 1e6 * e.protrusion.mean,
        1e6 * e.protrusion.max, e.uncovered_share, e.volume_ratio);
  }
  return text;
}

std::string ToCsv(const BodyTreeError& error, const std::string& mode, bool heading) {
  std::string text;
  if (heading) {
    text = "body,mode,level,kind,spheres";
    for (const auto& [name, value] : FiguresOf({})) text += std::string(",") + name;
    text += '\n';
  }
  for (std::size_t l = 0; l < error.levels.size(); ++l) {
    text += error.body + "," + mode + "," + std::to_string(l + 1) + "," + KindOf(error, l) + "," +
            std::to_string(error.levels[l].spheres);
    for (const auto& [name, value] : FiguresOf(error.levels[l])) text += Format(",%.9g", value);
    text += '\n';
  }
  return text;
}

std::string ToJsonText(const BodyTreeError& error) {
  nlohmann::ordered_json json{{"body", error.body}};
  for (std::size_t l = 0; l < error.levels.size(); ++l) {
    nlohmann::ordered_json level{
        {"level", l + 1}, {"kind", KindOf(error, l)}, {"spheres", error.levels[l].spheres}};
    for (const auto& [name, value] : FiguresOf(error.levels[l])) level[name] = value;
    json["levels"].push_back(std::move(level));
  }
  return json.dump();
}

}  // namespace palpate
