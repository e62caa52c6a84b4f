#include "scenes/shapes/bur_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "common/math/elementary.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"
#include "scenes/shapes/swept_mesh.h"

namespace palpate {
namespace {

constexpr int kSides = 32;
/// Directions in a quarter of the outline: with 16, a ball of 1.4 mm is accurate to 1 um.
constexpr int kQuarter = 16;
constexpr double kShank = 0.8e-3, kHandleRadius = 4e-3;  ///< radii [m]; a shank after ISO 1797

/// Returns the point of the outline, the thickened curve, that is farthest in the direction (cos a,
/// sin a): (rho, y).
std::array<double, 2> Farthest(const BurProfile& bur, double angle) {
  const double c = Cos(angle), s = Sin(angle);
  const auto along = [&](const std::array<double, 2>& p) { return p[0] * c + p[1] * s; };
  const auto& p =
      *std::max_element(bur.curve.begin(), bur.curve.end(),
                        [&](const auto& a, const auto& b) { return along(a) < along(b); });
  return {p[0] + bur.rounding * c, p[1] + bur.rounding * (s + 1.0)};
}

/// The form of a shape number of ISO 6360-2.
struct IsoShape {
  std::string_view number, kind, what;
  double shortest_mm = 0.0, longest_mm = 0.0;  ///< length of heads, as published; 0: the diameter
  enum class Edge { kFlat, kRoundEdge, kRoundEnd } edge = Edge::kFlat;
};
constexpr IsoShape kIsoShapes[] = {
    {"001", "ball", "ball"},
    {"010", "inverted_cone", "inverted cone", 1.0, 2.1},
    {"225", "inverted_cone", "inverted cone, long", 3.5, 5.0},
    {"237", "pear", "pear", 2.0, 3.0},
    {"233", "pear", "pear", 2.5, 2.7},
    {"234", "pear", "pear, long", 4.0, 7.0},
    {"107", "cylinder", "cylinder", 3.0, 4.0},
    {"110", "cylinder", "cylinder", 6.0, 6.0},
    {"111", "cylinder", "cylinder", 8.0, 8.0},
    {"139", "cylinder", "cylinder, round edge", 4.0, 4.0, IsoShape::Edge::kRoundEdge},
    {"140", "cylinder", "cylinder, round end", 6.0, 6.0, IsoShape::Edge::kRoundEnd},
    {"141", "cylinder", "cylinder, round end", 8.0, 8.0, IsoShape::Edge::kRoundEnd},
    {"142", "cylinder", "cylinder, round end", 10.0, 10.0, IsoShape::Edge::kRoundEnd},
    {"170", "cone", "taper", 3.0, 4.0},
    {"171", "cone", "taper", 6.0, 7.0},
    {"172", "cone", "taper", 8.0, 8.0},
    {"173", "cone", "taper", 10.0, 10.0},
    {"196", "cone", "taper, round end", 4.0, 4.0, IsoShape::Edge::kRoundEnd},
    {"197", "cone", "taper, round end", 6.0, 7.0, IsoShape::Edge::kRoundEnd},
    {"198", "cone", "taper, round end", 8.0, 8.0, IsoShape::Edge::kRoundEnd},
    {"199", "cone", "taper, round end", 10.0, 10.0, IsoShape::Edge::kRoundEnd},
    {"247", "flame", "flame", 5.0, 5.0},
    {"248", "flame", "flame", 6.0, 6.0},
    {"249", "flame", "flame", 8.0, 8.0},
    {"250", "flame", "flame", 10.0, 10.0},
};
constexpr double kTangentOfTaper = 0.03492076949;  // 2 degrees
constexpr double kFlatEdge = 0.1e-3;               ///< largest rounding of a flat end's edge [m]
constexpr int kSmallest = 5, kLargest = 50;        ///< sizes, 1/10 mm
constexpr double kFinestTip = 0.2e-3;              ///< least diameter of a taper's tip [m]

[[noreturn]] void RefuseName(const std::string& name) {
  const std::string known = Joined(kIsoShapes, [](const IsoShape& shape) {
    return std::string(shape.number) + " (" + std::string(shape.what) + ")";
  });
  throw Error(Quoted(name) +
              " is not a known bur; give SHAPE/SIZE as in ISO 6360, such as \"237/014\": the size "
              "in 1/10 mm from 005 to 050, the shape one of " +
              known + "; or a \"mesh\" of the shape \"bur\"");
}

}  // namespace

BurProfile BallBur(double radius) {
  return {{{0.0, 0.0}}, radius};
}

BurProfile ConeBur(double tip_radius, double top_radius, double length, double rounding) {
  rounding = std::min({rounding, tip_radius, top_radius, 0.4 * length});
  const double top = length - 2.0 * rounding;
  BurProfile bur{{{0.0, 0.0}}, rounding};
  if (tip_radius > rounding) bur.curve.push_back({tip_radius - rounding, 0.0});
  if (top_radius > rounding) bur.curve.push_back({top_radius - rounding, top});
  bur.curve.push_back({0.0, top});
  return bur;
}

BurProfile PearBur(double radius, double length) {
  // The rounding is half the radius of the ball at the tip.  The curve is then a quarter circle of
  // that radius, in three chords, and a straight line.
  const double half = 0.5 * radius, c30 = 0.86602540378443865;
  return {{{0.0, 0.0},
           {0.5 * half, half * (1.0 - c30)},
           {half * c30, 0.5 * half},
           {half, half},
           {0.0, std::max(length, 2.0 * radius) - radius}},
          half};
}

BurProfile FlameBur(double radius, double length) {
  const double rounding = 0.25 * radius, wide = radius - rounding, top = length - 2.0 * rounding;
  const double widest = 0.6 * top;
  return {{{0.0, 0.0},
           {5.0 / 9.0 * wide, widest / 3.0},
           {8.0 / 9.0 * wide, 2.0 * widest / 3.0},
           {wide, widest},
           {0.6 * wide, top},
           {0.0, top}},
          rounding};
}

BurProfile TrephineBur(double radius, double wall, double length, double rounding) {
  rounding = std::min({rounding, 0.4 * wall, 0.4 * length});
  const double outer = radius - rounding, inner = radius - wall + rounding;
  const double top = length - 2.0 * rounding;
  return {{{inner, 0.0}, {outer, 0.0}, {outer, top}, {inner, top}, {inner, 0.0}}, rounding};
}

NamedBur BurOfIso(const std::string& name) {
  const auto shape = std::ranges::find_if(
      kIsoShapes, [&](const IsoShape& s) { return name.substr(0, 3) == s.number; });
  const bool formed =
      name.size() == 7 && name[3] == '/' &&
      std::all_of(name.begin() + 4, name.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!formed || shape == std::end(kIsoShapes)) RefuseName(name);
  const int size = std::stoi(name.substr(4));
  if (size < kSmallest || size > kLargest) RefuseName(name);
  NamedBur bur{shape->kind, 1e-4 * size};
  bur.length = shape->longest_mm == 0.0
                   ? bur.diameter
                   : std::clamp(bur.diameter, 1e-3 * shape->shortest_mm, 1e-3 * shape->longest_mm);
  double tip = bur.diameter;
  if (shape->kind == "cone") {
    bur.tip_diameter = tip = bur.diameter - 2.0 * kTangentOfTaper * bur.length;
    if (tip < kFinestTip) {
      throw Error(Quoted(name) + " would be thinner than 0.2 mm at its tip; give a larger size");
    }
  }
  switch (shape->edge) {
    case IsoShape::Edge::kFlat:
      bur.rounding = std::min(kFlatEdge, 0.125 * tip);
      break;
    case IsoShape::Edge::kRoundEdge:
      bur.rounding = 0.25 * tip;
      break;
    case IsoShape::Edge::kRoundEnd:
      bur.rounding = 0.5 * tip;
      break;
  }
  return bur;
}

TriangleMesh MakeBur(const BurProfile& bur, double handle) {
  std::vector<std::array<double, 2>> curve;
  const double widest = Farthest(bur, 0.0)[0], top = Farthest(bur, 0.5 * M_PI)[1];
  const double shank = std::min(kShank, 0.6 * widest);
  // For a trephine, the bore's roof, wall and inner edge come first.
  const bool hollow = bur.curve.size() > 1 && bur.curve.front()[0] > 0.0;
  if (hollow) {
    const double bore = Farthest(bur, -M_PI)[0];
    curve.push_back({bore, top - (widest - bore)});
    for (int i = 0; i < kQuarter; ++i)
      curve.push_back(Farthest(bur, 0.5 * M_PI * (static_cast<double>(i) / kQuarter - 2.0)));
  }
  const auto add = [&](double y, double radius) {
    // A sharp edge is one point.
    const auto same = [](double a, double b) { return std::abs(a - b) < 1e-6; };
    if (curve.empty() || !same(radius, curve.back()[0]) || !same(y, curve.back()[1])) {
      curve.push_back({radius, y});
    }
  };
  std::array<double, 2> beyond{0.0, top};
  for (int i = 1; i <= 2 * kQuarter; ++i) {
    const double angle = 0.5 * M_PI * (static_cast<double>(i) / kQuarter - 1.0);
    const auto [rho, y] = Farthest(bur, angle);
    if (angle > 0.0 && rho < shank) {
      beyond = {rho, y};
      break;
    }
    if (rho > 0.02 * widest) add(y, rho);
  }
  // The neck rises from within the head, which clears its way: a shoulder above the outline cuts
  // nothing, and material that has come over it would keep the bur from being drawn out.
  if (const auto [rho, y] = curve.back(); rho > shank) {
    curve.push_back({shank, y + (rho - shank) / (rho - beyond[0]) * (beyond[1] - y)});
  }
  add(top + 2e-3, shank);
  add(top + 6e-3, kShank);
  add(top + 14e-3, kShank);
  add(top + 16e-3, 0.6 * kHandleRadius);
  add(top + 20e-3, kHandleRadius);
  add(std::max(handle, top + 22e-3), kHandleRadius);
  return MakeTurned(curve, kSides);
}

}  // namespace palpate
