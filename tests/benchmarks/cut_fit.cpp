#include "tests/benchmarks/cut_fit.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/text/without_mark.h"
#include "tests/benchmarks/figures.h"

namespace palpate::bench {
namespace {

double LawOf(const FittedLaw& law, const FeedForce& p) {
  return p.area * (law.pressure + p.share * law.viscosity * p.feed);
}

FittedLaw FitMaterial(const std::string& material, const std::vector<FeedForce>& points) {
  // Normal equations of F = a p_0 + b kappa.
  double aa = 0.0, ab = 0.0, bb = 0.0, af = 0.0, bf = 0.0;
  for (const FeedForce& p : points) {
    const double a = p.area, b = p.area * p.share * p.feed;
    aa += a * a;
    ab += a * b;
    bb += b * b;
    af += a * p.force;
    bf += b * p.force;
  }
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-9 * aa * bb)) {
    throw Error(material +
                ": has a single feed, which does not tell how its force is shared between "
                "cutting_pressure_MPa and cutting_viscosity_MPa_s_per_mm; add points at another");
  }
  FittedLaw law{material};
  law.pressure = (af * bb - bf * ab) / determinant;
  law.viscosity = (bf * aa - af * ab) / determinant;
  // If one would be negative, the best fit uses the other alone.
  if (law.viscosity < 0.0) law = {material, af / aa, 0.0};
  if (law.pressure < 0.0) law = {material, 0.0, bf / bb};
  double squares = 0.0;
  for (const FeedForce& p : points) squares += std::pow(p.force - LawOf(law, p), 2);
  law.residual = std::sqrt(squares / static_cast<double>(points.size()));
  return law;
}

bool IsNumber(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

double NumberIn(const std::string& text, double least, const std::string& where) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value) || value < least) {
    throw Error(where + "\"" + text + "\" is not a number of at least " + fmt::format("{}", least) +
                "; give material,area_mm2,share,feed_mm_per_s,force_N");
  }
  return value;
}

}  // namespace

std::vector<FittedLaw> FitLaw(const std::vector<FeedForce>& points) {
  std::vector<FittedLaw> laws;
  for (const FeedForce& first : points) {
    const auto known = [&](const FittedLaw& law) { return law.material == first.material; };
    if (std::ranges::any_of(laws, known)) continue;
    std::vector<FeedForce> own;
    std::ranges::copy_if(points, std::back_inserter(own),
                         [&](const FeedForce& p) { return p.material == first.material; });
    laws.push_back(FitMaterial(first.material, own));
  }
  return laws;
}

std::vector<FeedForce> ReadFeedForces(const std::string& file) {
  std::ifstream in(file);
  if (!in) {
    throw Error(file +
                ": cannot be opened; give --fit a CSV file of material,area_mm2,share,"
                "feed_mm_per_s,force_N");
  }
  std::vector<FeedForce> points;
  bool may_be_titles = true;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1) line = std::string(WithoutMark(line, file));
    std::erase(line, '\r');
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    // Titles have no number behind the first column; a first point has at least one.
    const bool has_number =
        std::any_of(cells.begin() + (cells.empty() ? 0 : 1), cells.end(), IsNumber);
    if (std::exchange(may_be_titles, false) && !has_number) continue;
    const std::string where = fmt::format("{}:{}: ", file, number);
    if (cells.size() != 5 || cells[0].empty()) {
      throw Error(where + "needs five columns: material,area_mm2,share,feed_mm_per_s,force_N");
    }
    points.push_back({cells[0], 1e-6 * NumberIn(cells[1], 1e-6, where),
                      NumberIn(cells[2], 0.0, where), 1e-3 * NumberIn(cells[3], 0.0, where),
                      NumberIn(cells[4], 0.0, where)});
  }
  if (points.empty()) throw Error(file + ": holds no point; give one in a row");
  return points;
}

void RunCutFit(const std::string& file, const std::string& json) {
  const std::vector<FeedForce> points = ReadFeedForces(file);
  auto rows = Json::array();
  for (const FittedLaw& law : FitLaw(points)) {
    fmt::print(stderr,
               "{}: \"cutting_pressure_MPa\": {:.4g}, \"cutting_viscosity_MPa_s_per_mm\": {:.4g}; "
               "residual {:.3g} N rms\n{:>10} {:>10} {:>10} {:>10}\n",
               law.material, 1e-6 * law.pressure, 1e-9 * law.viscosity, law.residual, "feed mm/s",
               "force N", "law N", "residual");
    auto residuals = Json::array();
    for (const FeedForce& p : points) {
      if (p.material != law.material) continue;
      const double residual = p.force - LawOf(law, p);
      fmt::print(stderr, "{:>10.4g} {:>10.4g} {:>10.4g} {:>+10.3g}\n", 1e3 * p.feed, p.force,
                 LawOf(law, p), residual);
      residuals.push_back(residual);
    }
    rows.push_back({{"material", law.material},
                    {"cutting_pressure_MPa", 1e-6 * law.pressure},
                    {"cutting_viscosity_MPa_s_per_mm", 1e-9 * law.viscosity},
                    {"residual_N_rms", law.residual},
                    {"residuals_N", residuals}});
  }
  if (!json.empty()) WriteJson(json, {{"file", file}, {"laws", rows}});
}

}  // namespace palpate::bench
