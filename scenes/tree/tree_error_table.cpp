#include "scenes/tree/tree_error_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr double kMicro = 1e6;

/// Returns what a level is: the last one is felt, and those above bound it.
const char* KindOf(const std::vector<UnionError>& levels, std::size_t level) {
  return level + 1 == levels.size() ? "leaves" : "bounds";
}

struct Figure {
  const char* of;     ///< the quantity
  const char* which;  ///< the statistic; empty: a single number
  double value;
};

/// Returns all figures of a level, in the order of the CSV's columns.
std::vector<Figure> FiguresOf(const UnionError& e) {
  return {{"outside_um", "mean", kMicro * e.protrusion.mean},
          {"outside_um", "p99", kMicro * e.protrusion.p99},
          {"outside_um", "max", kMicro * e.protrusion.max},
          {"uncovered_um", "mean", kMicro * e.bareness.mean},
          {"uncovered_um", "p99", kMicro * e.bareness.p99},
          {"uncovered_um", "max", kMicro * e.bareness.max},
          {"uncovered_share", "", e.uncovered_share},
          {"missed_share", "", e.missed_share},
          {"signed_offset_um", "mean", kMicro * e.offset.mean},
          {"signed_offset_um", "rms", kMicro * e.offset.rms},
          {"signed_offset_um", "min", kMicro * e.offset.min},
          {"signed_offset_um", "p1", kMicro * e.offset.p1},
          {"signed_offset_um", "p50", kMicro * e.offset.p50},
          {"signed_offset_um", "p99", kMicro * e.offset.p99},
          {"signed_offset_um", "max", kMicro * e.offset.max},
          {"normal_deg", "mean", kDegrees * e.tilt.mean},
          {"normal_deg", "p99", kDegrees * e.tilt.p99},
          {"normal_deg", "max", kDegrees * e.tilt.max},
          {"volume_ratio", "", e.volume_ratio},
          {"off_um", "p95", kMicro * e.off_p95},
          {"lean_deg", "mean", kDegrees * e.mean_lean}};
}

}  // namespace

std::string AboutLevelTable() {
  return fmt::format(
      "  signed offset  how high the balls' surface lies over the mesh's, along its normal; below "
      "it < 0\n"
      "  off            its size at 95 of 100 places, however high or low\n"
      "  sticks out     how far a ball reaches out of the solid\n"
      "  bare           share of the surface that lies in no ball\n"
      "  normal         angle between the balls' surface and the mesh's\n"
      "  volume         of all balls together, of the solid's\n"
      "  {}.\n"
      "  A coarser shape that may be felt is a tree of its own with fewer \"leaves\" "
      "(palpate-bench tree).\n",
      kWhatLevelsAre);
}

LengthUnit UnitOf(const std::vector<BodyTreeError>& errors) {
  // A sign and a narrower column each take a place.
  double high = 0.0, low = 0.0;
  for (const BodyTreeError& error : errors) {
    for (const UnionError& e : error.levels) {
      high = std::max({high, e.offset.max, e.protrusion.max});
      low = std::max({low, -e.offset.min, e.off_p95});
    }
  }
  const double longest = std::max(high, 10.0 * low);
  if (longest < 0.0999) return {"um", kMicro, 1};
  if (longest < 0.999) return {"mm", 1e3, 3};
  if (longest < 9.99) return {"mm", 1e3, 2};
  return {"m", 1.0, longest < 999.0 ? 3 : 1};
}

std::string LevelTable(const std::vector<UnionError>& levels, const LengthUnit& unit) {
  std::string text = fmt::format(
      "    {:<9}{:>8}{:^40}{:>7}{:^16}{:>6}{:^12}{:>7}\n"
      "    {:<9}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>7}{:>8}{:>8}{:>6}{:>6}{:>6}{:>7}\n",
      "level", "spheres", fmt::format("   signed offset, {}", unit.name), "off",
      fmt::format("  sticks out, {}", unit.name), "bare", " normal, deg", "volume", "", "", "mean",
      "p1", "p99", "min", "max", "p95", "p99", "max", "%", "mean", "p99", "%");
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const UnionError& e = levels[l];
    text +=
        fmt::format("    {:<9}{:>8}", fmt::format("{}, {}", l + 1, KindOf(levels, l)), e.spheres);
    for (const auto& [length, width] : {std::pair{e.offset.mean, 8},
                                        {e.offset.p1, 8},
                                        {e.offset.p99, 8},
                                        {e.offset.min, 8},
                                        {e.offset.max, 8},
                                        {e.off_p95, 7},
                                        {e.protrusion.p99, 8},
                                        {e.protrusion.max, 8}}) {
      text += fmt::format("{:>{}.{}f}", unit.per_metre * length, width, unit.digits);
    }
    text += fmt::format("{:>6.1f}{:>6.1f}{:>6.1f}{:>7.1f}\n", 100.0 * e.uncovered_share,
                        kDegrees * e.tilt.mean, kDegrees * e.tilt.p99, 100.0 * e.volume_ratio);
  }
  return text;
}

std::string ToText(const BodyTreeError& error) {
  return "  " + error.body + "\n" + LevelTable(error.levels, UnitOf({error}));
}

std::string ToJsonText(const BodyTreeError& error) {
  nlohmann::ordered_json json{{"body", error.body}};
  json["levels"] = nlohmann::ordered_json::array();
  for (std::size_t l = 0; l < error.levels.size(); ++l) {
    nlohmann::ordered_json level{
        {"level", l + 1}, {"kind", KindOf(error.levels, l)}, {"spheres", error.levels[l].spheres}};
    for (const Figure& figure : FiguresOf(error.levels[l])) {
      nlohmann::ordered_json& place = level[figure.of];
      (*figure.which ? place[figure.which] : place) = figure.value;
    }
    json["levels"].push_back(std::move(level));
  }
  return json.dump();
}

}  // namespace palpate
