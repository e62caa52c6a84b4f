#include "scenes/shapes/tooth_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/math/elementary.h"
#include "scenes/mesh/mesh_simplify.h"

namespace palpate {
namespace {

constexpr int kPlaces = 7;

/// A dimension of the crown at five heights from the neck to the top, interpolated smoothly.
using Profile = std::array<double, 5>;

double At(const Profile& profile, double height) {
  const double s = 4.0 * std::clamp(height, 0.0, 1.0);
  const int i = std::min(int(s), 3);
  const double t = s - i;
  const double a = profile[std::max(i - 1, 0)];
  const double b = profile[i];
  const double c = profile[i + 1];
  const double d = profile[std::min(i + 2, 4)];
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/// Part of the chewing surface: a ridge from one point to another, or a cusp if they coincide, that
/// falls off with `slope`.  x is towards the middle of the arch, z outwards, in half widths and
/// half depths; heights are shares of the crown's.
struct Ridge {
  double x0, z0, x1, z1, height, slope;
};

/// A root: where its tip lies, and its half widths at the neck, as shares of the size.
struct Root {
  double x, z, tip_x, tip_z, half_width, half_depth, length;
};

struct Form {
  Profile mesial, distal;   ///< from the axis towards the arch's middle and away, in half widths
  Profile labial, lingual;  ///< from the axis outwards and inwards, in half depths
  double squareness;        ///< exponent of a section's superellipse
  std::vector<Ridge> ridges;
  std::vector<Root> roots;
};

// Where two ridges meet, the higher counts, so there are fissures between cusps.

/// @param distal_height  of the edge's far end; its near end is at 1.
Form Incisor(bool upper, double distal_height) {
  const double wide = upper ? 0.62 : 0.6;
  return {{wide, 0.82, 0.93, 1.03, 1.02},
          {wide, 0.82, 0.96, 1.0, 0.9},
          {0.86, 0.98, 0.9, 0.72, 0.44},
          {0.84, 0.98, 0.52, 0.12, -0.14},
          2.5,
          {{0.8, 0.16, 0.0, 0.15, 1.0, 0.35}, {0.0, 0.15, -0.62, 0.13, distal_height, 0.35}},
          {{0, 0, -0.08, -0.1, 0.52, 0.8, 1.0}}};
}

Form Canine(bool upper) {
  return {{0.64, 0.84, 0.98, 0.9, 0.5},
          {0.64, 0.86, 1.0, 0.84, 0.4},
          {0.86, 1.0, 0.96, 0.74, 0.4},
          {0.86, 0.98, 0.6, 0.22, -0.06},
          2.2,
          {{0.06, 0.2, 0.06, 0.2, 1.0, 0.5}},
          {{0, 0, -0.1, -0.05, upper ? 0.54 : 0.5, 0.82, 1.0}}};
}

Form Premolar(bool upper, bool second) {
  const double lingual = upper ? (second ? 0.95 : 0.86) : (second ? 0.84 : 0.7);
  const double inner = upper ? -0.48 : -0.42;
  return {{0.68, 0.9, 1.0, 0.92, 0.7},
          {0.68, 0.9, 1.0, 0.9, 0.66},
          {0.84, 1.0, 0.96, 0.8, 0.56},
          {0.84, 0.96, 1.0, 0.9, 0.66},
          2.4,
          {{0.0, 0.5, 0.0, 0.5, 1.0, 0.62},
           {0.1, inner, 0.1, inner, lingual, 0.6},
           {0.78, 0.3, 0.76, -0.3, 0.76, 0.55},
           {-0.78, 0.3, -0.76, -0.3, 0.74, 0.55}},
          {{0, 0, -0.12, 0, 0.54, 0.78, 1.0}}};
}

Form UpperMolar(bool second) {
  const double far = second ? 0.78 : 0.86;  // the cusp that shrinks towards the back
  return {{0.76, 0.94, 1.0, 0.95, 0.84},
          {0.76, 0.92, 0.98, 0.92, 0.78},
          {0.84, 0.99, 0.97, 0.88, 0.7},
          {0.84, 0.97, 1.0, 0.92, 0.74},
          2.9,
          {{0.5, 0.55, 0.5, 0.55, 0.98, 0.58},
           {-0.46, 0.55, -0.46, 0.55, 0.92, 0.58},
           {0.42, -0.5, 0.36, -0.44, 1.0, 0.54},
           {-0.56, -0.6, -0.56, -0.6, far, 0.58},
           {0.3, -0.34, -0.4, 0.42, 0.77, 0.5},  // the oblique ridge
           {0.84, 0.36, 0.84, -0.32, 0.8, 0.5},
           {-0.84, 0.36, -0.84, -0.4, 0.74, 0.5}},
          {{0.42, 0.36, 0.62, 0.4, 0.3, 0.36, 0.96},
           {-0.42, 0.36, -0.6, 0.4, 0.28, 0.34, 0.92},
           {0, -0.4, 0, -0.72, 0.38, 0.36, 1.0}}};
}

Form LowerMolar(bool second) {
  Form form{{0.78, 0.95, 1.0, 0.95, 0.84},
            {0.78, 0.95, 1.0, 0.93, 0.8},
            {0.84, 1.0, 0.95, 0.8, 0.6},
            {0.82, 0.95, 1.0, 0.95, 0.8},
            2.9,
            {{0.48, -0.58, 0.48, -0.58, 1.0, 0.56},
             {-0.44, -0.58, -0.44, -0.58, 0.96, 0.56},
             {0.84, 0.3, 0.84, -0.34, 0.8, 0.5},
             {-0.84, 0.2, -0.84, -0.34, 0.76, 0.5}},
            {{0.44, 0, 0.5, 0, 0.36, 0.66, 1.0}, {-0.44, 0, -0.62, 0, 0.34, 0.6, 0.95}}};
  if (second) {
    form.ridges.push_back({0.48, 0.5, 0.48, 0.5, 0.93, 0.56});
    form.ridges.push_back({-0.46, 0.5, -0.46, 0.5, 0.9, 0.56});
  } else {  // three on the outer side
    form.ridges.push_back({0.56, 0.5, 0.56, 0.5, 0.92, 0.6});
    form.ridges.push_back({-0.08, 0.55, -0.08, 0.55, 0.91, 0.6});
    form.ridges.push_back({-0.64, 0.38, -0.64, 0.38, 0.85, 0.6});
  }
  return form;
}

Form FormOf(ToothNumber tooth) {
  const bool upper = tooth.upper();
  switch (tooth.place) {
    case 1:
      return Incisor(upper, upper ? 0.97 : 0.99);
    case 2:
      return Incisor(upper, upper ? 0.92 : 0.97);
    case 3:
      return Canine(upper);
    case 4:
    case 5:
      return Premolar(upper, tooth.place == 5);
    default:
      return upper ? UpperMolar(tooth.place == 7) : LowerMolar(tooth.place == 7);
  }
}

/// Returns the height of the chewing surface [mm].
double TopAt(const Form& form, const ToothMeasures& size, double x, double z) {
  double top = 0.5 * size.crown;
  for (const Ridge& ridge : form.ridges) {
    const Eigen::Vector2d half(0.5 * size.width, 0.5 * size.depth);
    const Eigen::Vector2d a = half.cwiseProduct(Eigen::Vector2d(ridge.x0, ridge.z0));
    const Eigen::Vector2d along = half.cwiseProduct(Eigen::Vector2d(ridge.x1, ridge.z1)) - a;
    const Eigen::Vector2d from = Eigen::Vector2d(x, z) - a;
    const double t = std::clamp(from.dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
    constexpr double kTip = 0.5;  // radius of pointed parts
    const double off = (from - t * along).norm();
    const double height = ridge.height * size.crown;
    if (FarAbove(top, height - ridge.slope * (off - kTip), 0.25)) continue;
    top = SmoothMax(top, height - ridge.slope * (Length(off, kTip) - kTip), 0.25);
  }
  return top;
}

/// Returns a lower bound of the crown's field.
double BelowNeck(const Vec3& p) {
  return -(p.y() + 1.5);
}

Field CrownField(const Form& form, const ToothMeasures& size) {
  return [=](const Vec3& p) {
    const double s = p.y() / size.crown;
    // Neighbours turn away from each other round the arch, but must touch.
    constexpr double kTouch = 1.04;
    const double towards =
        0.5 * kTouch * size.width * At(p.x() > 0.0 ? form.mesial : form.distal, s);
    const double front = 0.5 * size.depth * At(form.labial, s);
    const double back = 0.5 * size.depth * At(form.lingual, s);
    const double half = std::max(0.5 * (front + back), 0.3);
    const double z = p.z() - 0.5 * (front - back);
    const double n = form.squareness;
    const double u = std::abs(p.x()) / towards;
    const double w = std::abs(z) / half;
    const auto side = [&] {
      const double r = Pow(Pow(u, n) + Pow(w, n), 1.0 / n);
      return (r - 1.0) * std::min(towards, half);
    };
    const auto lid = [&] { return 0.8 * (p.y() - TopAt(form, size, p.x(), p.z())); };
    const double low = 0.8 * (p.y() - 0.5 * size.crown);  // the lid is nowhere higher
    double walls;
    if (low < 0.0) {
      walls = side();
      if (!FarAbove(walls, low, 0.7)) walls = SmoothMax(walls, lid(), 0.7);
    } else {
      walls = lid();
      const double most = (u + w - 1.0) * std::min(towards, half);
      if (!FarAbove(walls, most, 0.7)) walls = SmoothMax(side(), walls, 0.7);
    }
    return SmoothMax(walls, BelowNeck(p), 1.0);
  };
}

Field RootField(const Root& root, const ToothMeasures& size) {
  constexpr double kTipRadius = 0.8;
  const double half_width = 0.5 * size.width * root.half_width;
  const double flat = root.half_width * size.width / (root.half_depth * size.depth);
  const double length = root.length * size.root;
  const Vec3 top(0.5 * size.width * root.x, -0.4, 0.5 * size.depth * root.z * flat);
  const Vec3 tip(0.5 * size.width * root.tip_x, -length + kTipRadius,
                 0.5 * size.depth * root.tip_z * flat);
  const Field cone = ConeField(top, half_width, tip, kTipRadius);
  return [=](const Vec3& p) { return cone({p.x(), p.y(), flat * p.z()}); };
}

}  // namespace

std::span<const std::string_view> ToothNames() {
  static constexpr std::string_view kNames[] = {
      "11", "12", "13", "14", "15", "16", "17", "21", "22", "23", "24", "25", "26", "27",
      "31", "32", "33", "34", "35", "36", "37", "41", "42", "43", "44", "45", "46", "47"};
  return kNames;
}

ToothNumber NumberOf(std::size_t name) {
  return {int(name) / kPlaces + 1, int(name) % kPlaces + 1};
}

ToothMeasures MeasuresOf(ToothNumber tooth) {
  static constexpr ToothMeasures kUpper[kPlaces] = {
      {8.5, 7, 10.5, 13}, {6.5, 6, 9, 13},     {7.5, 8, 10, 15},  {7, 9, 8.5, 14},
      {7, 9, 8.5, 14},    {10.5, 11, 7.5, 12}, {9.5, 10.5, 7, 11}};
  static constexpr ToothMeasures kLower[kPlaces] = {
      {5.3, 6, 9, 12.5}, {5.8, 6.3, 9.5, 14}, {6.8, 7.8, 10.5, 15}, {7, 7.8, 8.5, 14},
      {7.2, 8.2, 8, 14}, {11, 10.3, 7.5, 13}, {10.5, 10.2, 7, 12}};
  return (tooth.upper() ? kUpper : kLower)[tooth.place - 1];
}

Field ToothFormField(ToothNumber tooth, const ToothMeasures& size) {
  const Form form = FormOf(tooth);
  constexpr double kBlend = 1.2;
  std::vector<Field> parts;
  if (form.roots.size() > 1) {  // the trunk above the furcation
    parts.push_back(EllipsoidField({0, -1.5, 0}, {0.4 * size.width, 3.0, 0.4 * size.depth}));
  }
  for (const Root& root : form.roots) parts.push_back(RootField(root, size));
  parts.front() = [crown = CrownField(form, size), below = parts.front()](const Vec3& p) {
    const double deep = below(p);
    return FarAbove(BelowNeck(p), deep, kBlend) ? deep : SmoothMin(crown(p), deep, kBlend);
  };
  const Field whole = UnionOf(std::move(parts), kBlend);
  const double mesial = tooth.quadrant % 2 == 0 ? 1.0 : -1.0;
  return [=](const Vec3& p) { return whole({mesial * p.x(), p.y(), p.z()}); };
}

TriangleMesh MakeToothForm(ToothNumber tooth, const ToothMeasures& size) {
  constexpr double kCell = 0.55;        // half of a fissure's width
  constexpr double kTolerance = 0.025;  // less than a probe's tip can distinguish
  const double x = 0.5 * size.width + 2.0;
  const double z = 0.5 * size.depth + 2.0;
  const Eigen::AlignedBox3d box(Vec3(-x, -size.root - 1.5, -z), Vec3(x, size.crown + 1.5, z));
  TriangleMesh mesh = Simplified(MeshOfField(ToothFormField(tooth, size), box, kCell), kTolerance);
  for (Vec3& v : mesh.vertices) v *= 1e-3;
  return mesh;
}

ArchAxes ArchOf(bool upper) {
  return upper ? ArchAxes{25.0, 45.0} : ArchAxes{23.5, 43.0};
}

std::vector<PlacedTooth> TeethOf(bool upper) {
  const ArchAxes arch = ArchOf(upper);
  // Distances along the quarter of the ellipse from its front, x > 0.
  constexpr int kSteps = 20000;
  std::vector<double> length{0.0};
  const auto point = [&](int i) {
    const double a = 0.5 * std::numbers::pi * i / kSteps;
    return Eigen::Vector2d(arch.half_width * Sin(a), arch.length * Cos(a));
  };
  for (int i = 1; i <= kSteps; ++i)
    length.push_back(length.back() + (point(i) - point(i - 1)).norm());
  const int plus = upper ? 1 : 3;  // the quadrant at +x; an upper jaw is turned over about z
  const int minus = upper ? 2 : 4;
  double sum = 0.0;
  for (int place = 1; place <= kPlaces; ++place) sum += MeasuresOf({plus, place}).width;
  std::vector<PlacedTooth> teeth(2 * kPlaces);
  double at = 0.0;
  for (int place = 1; place <= kPlaces; ++place) {
    const double half = 0.5 * MeasuresOf({plus, place}).width;
    at += half;
    const double along = at / sum * length.back();
    const int i = int(std::lower_bound(length.begin(), length.end(), along) - length.begin());
    at += half;
    const Eigen::Vector2d p = point(i);
    // The direction of the ellipse's normal, which z follows.
    const double angle =
        Atan2(p.x() / (arch.half_width * arch.half_width), p.y() / (arch.length * arch.length));
    teeth[kPlaces - place] = {{plus, place}, p.x(), p.y(), angle};
    teeth[kPlaces + place - 1] = {{minus, place}, -p.x(), p.y(), -angle};
  }
  return teeth;
}

}  // namespace palpate
