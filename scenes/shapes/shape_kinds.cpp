#include "scenes/shapes/shape_kinds.h"

#include <algorithm>

#include "scenes/shapes/bur_shapes.h"
#include "scenes/shapes/dental_shapes.h"
#include "scenes/shapes/mouth_shapes.h"
#include "scenes/shapes/shapes.h"

namespace palpate {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

ShapeParameter Millimetres(std::string_view field, double usual, double smallest, double largest) {
  return {field, usual, smallest, largest, 1e-3};
}

std::vector<ShapeParameter> WithToothSize(std::vector<ShapeParameter> more) {
  std::vector<ShapeParameter> all{
      Millimetres("width_mm", 0, 2, 30), Millimetres("depth_mm", 0, 2, 30),
      Millimetres("crown_mm", 0, 2, 30), Millimetres("root_mm", 0, 4, 40)};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// Returns the size; values that the file omits are usual for the kind of tooth.
ToothSize SizeFrom(ToothKind kind, std::span<const double> values) {
  const ToothSize usual = UsualSize(kind);
  const auto or_usual = [](double value, double of_kind) { return value > 0.0 ? value : of_kind; };
  return {or_usual(values[0], usual.width), or_usual(values[1], usual.depth),
          or_usual(values[2], usual.crown), or_usual(values[3], usual.root)};
}

using Values = std::span<const double>;

/// Returns the gum's size.  If the file gives the depth at one site, sites that it omits have
/// the general depth.
GumSize GumFrom(Values v) {
  GumSize gum{v[4], v[5], v[6]};
  const Values sites = v.subspan(7, gum.sites.size());
  if (std::ranges::all_of(sites, [](double depth) { return depth == 0.0; })) return gum;
  std::ranges::transform(sites, gum.sites.begin(),
                         [&](double depth) { return depth > 0.0 ? depth : gum.pocket_depth; });
  return gum;
}

/// The parameters of burs; if the file gives a curve (rho, z), it follows them.
enum : std::size_t {
  kDiameter,
  kLength,
  kTip,
  kRounding,
  kHandle,
  kDeadTip,
  kCutting,
  kWall,
  kCurve
};
const std::vector<std::string_view> kBurs{"ball", "cylinder", "cone",    "inverted_cone",
                                          "pear", "flame",    "trephine"};

/// Makes the profile.  A ball has only a diameter.  A cone whose tip the file omits is half as wide
/// there; an inverted cone is always three quarters as wide at its top.
BurProfile FormFrom(std::size_t variant, Values v) {
  const double radius = 0.5 * v[kDiameter], length = v[kLength], rounding = v[kRounding];
  if (variant >= kBurs.size()) {
    BurProfile bur{{}, rounding};
    for (std::size_t i = kCurve; i + 1 < v.size(); i += 2) bur.curve.push_back({v[i], v[i + 1]});
    return bur;
  }
  if (kBurs[variant] == "ball") return BallBur(radius);
  if (kBurs[variant] == "cylinder") return ConeBur(radius, radius, length, rounding);
  if (kBurs[variant] == "pear") return PearBur(radius, length);
  if (kBurs[variant] == "flame") return FlameBur(radius, length);
  if (kBurs[variant] == "trephine") return TrephineBur(radius, v[kWall], length, rounding);
  if (kBurs[variant] == "inverted_cone") return ConeBur(radius, 0.75 * radius, length, rounding);
  return ConeBur(v[kTip] > 0.0 ? 0.5 * v[kTip] : 0.5 * radius, radius, length, rounding);
}

BurProfile ProfileFrom(std::size_t variant, Values v) {
  BurProfile bur = FormFrom(variant, v);
  bur.dead_tip = v[kDeadTip];
  bur.cutting = v[kCutting];
  return bur;
}

}  // namespace

std::span<const ShapeKind> ShapeKinds() {
  static const std::vector<std::string_view> kTeeth(ToothKindNames().begin(),
                                                    ToothKindNames().end());
  static const std::vector<ShapeKind> kKinds{
      {"tooth", kTeeth, WithToothSize({}),
       [](std::size_t variant, Values v) {
         const auto kind = static_cast<ToothKind>(variant);
         return MakeTooth(kind, SizeFrom(kind, v));
       }},
      {"dentine", kTeeth, WithToothSize({Millimetres("enamel_mm", 2, 0.5, 3)}),
       [](std::size_t variant, Values v) {
         const auto kind = static_cast<ToothKind>(variant);
         return MakeDentine(kind, SizeFrom(kind, v), v[4]);
       }},
      {"gingiva", kTeeth,
       WithToothSize(
           {Millimetres("pocket_depth_mm", 6, 1, 12), Millimetres("pocket_width_mm", 1.2, 0.4, 4),
            Millimetres("recession_mm", 0, 0, 4), Millimetres("mesial_outside_mm", 0, 1, 12),
            Millimetres("outside_mm", 0, 1, 12), Millimetres("distal_outside_mm", 0, 1, 12),
            Millimetres("mesial_inside_mm", 0, 1, 12), Millimetres("inside_mm", 0, 1, 12),
            Millimetres("distal_inside_mm", 0, 1, 12)}),
       [](std::size_t variant, Values v) {
         const auto kind = static_cast<ToothKind>(variant);
         return MakeGingiva(kind, SizeFrom(kind, v), GumFrom(v));
       },
       [](std::size_t variant, Values v) {
         const auto kind = static_cast<ToothKind>(variant);
         return GingivalMargin(kind, SizeFrom(kind, v), GumFrom(v));
       }},
      {"calculus", kTeeth, WithToothSize({Millimetres("across_mm", 4, 1, 10)}),
       [](std::size_t variant, Values v) {
         const auto kind = static_cast<ToothKind>(variant);
         return MakeCalculus(kind, SizeFrom(kind, v), v[4]);
       }},
      {"mandible",
       {"bone", "marrow", "nerve"},
       {Millimetres("length_mm", 20, 10, 60), Millimetres("cortex_mm", 2, 0.5, 4)},
       [](std::size_t variant, Values v) {
         return MakeMandible(static_cast<JawPart>(variant), v[0], v[1]);
       }},
      {"probe",
       {},
       {Millimetres("tip_radius_mm", 0.4, 0.2, 1), Millimetres("length_mm", 60, 40, 150)},
       [](std::size_t, Values v) { return MakeProbe(v[0], v[1]); }},
      {"scaler",
       {},
       {Millimetres("tip_radius_mm", 0.3, 0.15, 0.6), Millimetres("length_mm", 60, 40, 150)},
       [](std::size_t, Values v) { return MakeScaler(v[0], v[1]); }},
      {"mirror",
       {},
       {Millimetres("diameter_mm", 20, 10, 30), Millimetres("length_mm", 90, 50, 150)},
       [](std::size_t, Values v) { return MakeMirror(v[0], v[1]); }},
      {"jaw",
       {"upper", "lower"},
       {},
       [](std::size_t variant, Values) { return MakeJaw(variant == 0); }},
      {"tongue",
       {},
       {Millimetres("length_mm", 60, 20, 120)},
       [](std::size_t, Values v) { return MakeTongue(v[0]); }},
      {"face",
       {},
       {Millimetres("mouth_width_mm", 58, 40, 66), Millimetres("mouth_height_mm", 54, 30, 62)},
       [](std::size_t, Values v) { return MakeFace(v[0], v[1]); }},
      {"pipe",
       {},
       {Millimetres("inner_radius_mm", 20, 0.1, 1e5),
        Millimetres("wall_mm", 2, 0.01, 1e5),
        Millimetres("length_mm", 100, 0.1, 1e6),
        {"bend_deg", 0, 0, 300, kDegree}},
       [](std::size_t, Values v) { return MakeBentPipe(v[0], v[1], v[2], v[3]); }},
      {"mould",
       {"mould", "tool"},
       {Millimetres("radius_mm", 30, 1, 1000), Millimetres("depth_mm", 10, 0.1, 500),
        Millimetres("wave_mm", 1, 0.0, 50), Millimetres("thickness_mm", 8, 0.1, 500)},
       [](std::size_t variant, Values v) {
         return MakeMould(variant == 0, v[0], v[1], v[2], v[3]);
       }},
      {"bur",
       kBurs,
       {Millimetres("diameter_mm", 1.4, 0.3, 10), Millimetres("length_mm", 4, 0.5, 20),
        Millimetres("tip_diameter_mm", 0, 0.2, 10), Millimetres("rounding_mm", 0.1, 0.02, 5),
        Millimetres("handle_mm", 60, 30, 150), Millimetres("dead_tip_mm", 0, 0, 20),
        Millimetres("cutting_mm", 0, 0.05, 20), Millimetres("wall_mm", 0.4, 0.1, 4)},
       [](std::size_t variant, Values v) { return MakeBur(ProfileFrom(variant, v), v[kHandle]); },
       nullptr,
       ProfileFrom},
  };
  return kKinds;
}

ShapeChoice BurNamed(const std::string& name) {
  const NamedBur bur = BurOfIso(name);
  const ShapeKind& kind = *FindShapeKind("bur");
  ShapeChoice choice;
  choice.variant = static_cast<std::size_t>(std::ranges::find(kBurs, bur.kind) - kBurs.begin());
  for (const ShapeParameter& p : kind.parameters) choice.values.push_back(p.unit * p.usual);
  choice.values[kDiameter] = bur.diameter;
  choice.values[kLength] = bur.length;
  choice.values[kTip] = bur.tip_diameter;
  choice.values[kRounding] = bur.rounding;
  return choice;
}

const ShapeKind* FindShapeKind(std::string_view name) {
  const auto kinds = ShapeKinds();
  const auto it = std::find_if(kinds.begin(), kinds.end(),
                               [&](const ShapeKind& kind) { return kind.name == name; });
  return it == kinds.end() ? nullptr : &*it;
}

}  // namespace palpate
