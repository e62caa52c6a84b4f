#include "scenes/tree/tree_error_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr double kMicro = 1e6;
/// A table whose offsets reach this far shows millimetres, to a micrometre [m].
constexpr double kLarge = 0.1;

/// What a level is: the last is felt; those above bound it.
const char* KindOf(const std::vector<UnionError>& levels, std::size_t level) {
  return level + 1 == levels.size() ? "leaves" : "bounds";
}

struct Figure {
  const char* of;     ///< what the figure is of
  const char* which;  ///< of its spread; empty: it is one number
  double value;
};

/// Every figure of a level, in the order of the CSV's columns.
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
          {"volume_ratio", "", e.volume_ratio}};
}

}  // namespace

std::string LevelTable(const std::vector<UnionError>& levels) {
  const bool large = std::ranges::any_of(levels, [](const UnionError& e) {
    return std::max({-e.offset.min, e.offset.max, e.protrusion.max}) >= kLarge;
  });
  const char* unit = large ? "mm" : "um";
  const double scale = large ? 1e3 : kMicro;
  const int digits = large ? 3 : 1;
  std::string text = fmt::format(
      "    {:<11} {:>7}  {:^49}  {:^29}  {:^14}  {:>5} {:>7}\n"
      "    {:<11} {:>7}  {:>9} {:>9} {:>9} {:>9} {:>9}  {:>9} {:>9} {:>9}  {:>6} {:>7}  {:>5} "
      "{:>7}\n",
      "level", "spheres", fmt::format("signed offset of the union, {}", unit),
      fmt::format("outside of the solid, {}", unit), "normal, deg", "bare", "volume", "", "",
      "mean", "p1", "p99", "min", "max", "mean", "p99", "max", "mean", "p99", "%", "%");
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const UnionError& e = levels[l];
    text += fmt::format("    {:<11} {:>7} ", fmt::format("{}, {}", l + 1, KindOf(levels, l)),
                        e.spheres);
    const auto lengths = [&](std::initializer_list<double> values) {
      for (const double v : values) text += fmt::format(" {:>9.{}f}", scale * v, digits);
      text += ' ';
    };
    lengths({e.offset.mean, e.offset.p1, e.offset.p99, e.offset.min, e.offset.max});
    lengths({e.protrusion.mean, e.protrusion.p99, e.protrusion.max});
    text += fmt::format(" {:>6.2f} {:>7.2f}  {:>5.1f} {:>7.2f}\n", kDegrees * e.tilt.mean,
                        kDegrees * e.tilt.p99, 100.0 * e.uncovered_share, 100.0 * e.volume_ratio);
  }
  return text;
}

std::string ToText(const BodyTreeError& error) {
  return "  " + error.body + "\n" + LevelTable(error.levels);
}

std::string ToCsv(const BodyTreeError& error, std::string_view mode, bool heading) {
  std::string text;
  if (heading) {
    text = "body,mode,level,kind,spheres";
    for (const Figure& figure : FiguresOf({})) {
      text += fmt::format(",{}{}{}", figure.of, *figure.which ? "_" : "", figure.which);
    }
    text += '\n';
  }
  for (std::size_t l = 0; l < error.levels.size(); ++l) {
    text += fmt::format("{},{},{},{},{}", error.body, mode, l + 1, KindOf(error.levels, l),
                        error.levels[l].spheres);
    for (const Figure& figure : FiguresOf(error.levels[l])) {
      text += fmt::format(",{:.9g}", figure.value);
    }
    text += '\n';
  }
  return text;
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
