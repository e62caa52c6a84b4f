#include "scenes/shapes/mouth_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/math/elementary.h"
#include "scenes/mesh/mesh_simplify.h"
#include "scenes/shapes/implicit_mesh.h"
#include "scenes/shapes/tooth_forms.h"

namespace palpate {
namespace {

// All below is in millimetres, as usual in dentistry, and scaled at the end.

TriangleMesh SoftMesh(const Field& field, const Eigen::AlignedBox3d& box, double cell,
                      double tolerance) {
  TriangleMesh mesh = Simplified(MeshOfField(field, box, cell), tolerance);
  for (Vec3& v : mesh.vertices) v *= 1e-3;
  return mesh;
}

double Step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Gum round one tooth's neck and roots, in the jaw's frame.
class Collar {
 public:
  explicit Collar(const PlacedTooth& tooth)
      : at_(tooth.x, 0.0, tooth.z), c_(Cos(tooth.angle)), s_(Sin(tooth.angle)) {
    const ToothMeasures size = MeasuresOf(tooth.number);
    half_width_ = 0.5 * size.width;
    half_depth_ = 0.5 * size.depth;
    papilla_ = tooth.number.place <= 3 ? 3.0 : 2.2;
  }

  /// Returns the field of the gum with this collar added.
  double AddedTo(double gum, const Vec3& p) const {
    constexpr double kFar = 8.0;  // from the axis; no collar reaches so far
    constexpr double kBlend = 1.2;
    const double dx = p.x() - at_.x();
    const double dz = p.z() - at_.z();
    if (FarAbove(std::max(std::abs(dx), std::abs(dz)) - kFar, gum, kBlend)) return gum;
    const double far = Length(dx, dz);
    if (far >= kNone) return SmoothMin(gum, far - kFar, kBlend);
    const double u = (c_ * dx - s_ * dz) / half_width_;
    const double w = s_ * dx + c_ * dz;
    const double below = Step(0.5, -7.0, p.y());
    // The neck's section is 0.86 of the crown's; the gum thickens from its margin downwards.
    const double depth = 0.88 * half_depth_ + 0.65 + 1.3 * below;
    constexpr double kReach = 1.14;  // beyond the middle between two teeth
    constexpr double kSquareness = 2.5;
    const double along = std::abs(u) / kReach;
    const double across = std::abs(w) / depth;
    const double size = std::min(kReach * half_width_, depth);
    // Compare a lower bound of the collar's field.
    if (FarAbove((std::max(along, across) - 1.0) * size, gum, kBlend)) return gum;
    const double r = Pow(Pow(along, kSquareness) + Pow(across, kSquareness), 1.0 / kSquareness);
    double collar = (r - 1.0) * size;
    if (constexpr double kLowest = 1.1; !FarAbove(collar, 0.85 * (p.y() - kLowest), 1.1)) {
      const double margin = kLowest + papilla_ * Pow(std::min(std::abs(u), 1.15), 2.8);
      collar = SmoothMax(collar, 0.85 * (p.y() - margin), 1.1);
    }
    return SmoothMin(gum, SmoothMax(collar, -(p.y() + 13.0), 2.0), kBlend);
  }

  static constexpr double kNone = 13.0;  // the value where there is no gum yet

 private:
  Vec3 at_;
  double c_, s_;
  double half_width_, half_depth_;
  double papilla_;
};

Field GumField(bool upper) {
  std::vector<Collar> collars;
  for (const PlacedTooth& tooth : TeethOf(upper)) collars.emplace_back(tooth);
  return [=](const Vec3& p) {
    double gum = Collar::kNone;
    for (const Collar& collar : collars) gum = collar.AddedTo(gum, p);
    return gum;
  };
}

/// Returns the bone's ridge below the necks, along the arch.
Field RidgeField(const ArchAxes& arch, double bottom) {
  std::vector<Vec3> curve;
  for (int i = 0; i <= 64; ++i) {
    const double a = std::numbers::pi * i / 64;
    curve.emplace_back(arch.half_width * Cos(a), 0.0, arch.length * Sin(a));
  }
  const Field distance = RopeField(curve, 0.0);
  return [=](const Vec3& p) {
    constexpr double kTop = -3.0;
    constexpr double kRound = 3.5;
    const double half = 5.0 + 0.14 * std::clamp(-p.y(), 0.0, -bottom);  // wider below
    const double qx = distance({p.x(), 0.0, p.z()}) - (half - kRound);
    const double qy = std::abs(p.y() - 0.5 * (kTop + bottom)) - (0.5 * (kTop - bottom) - kRound);
    return Length(std::max(qx, 0.0), std::max(qy, 0.0)) + std::min(std::max(qx, qy), 0.0) - kRound;
  };
}

/// Returns the filling of the arch: an upper jaw's vault with its rugae, or a lower
/// jaw's flat floor.
Field VaultField(const ArchAxes& arch, bool upper, double bottom) {
  return [=](const Vec3& p) {
    const double e = Length(p.x() / arch.half_width, std::max(p.z(), 0.0) / arch.length);
    double roof = upper ? -1.5 - 9.0 * Step(1.0, 0.35, e) : -9.0;
    if (upper) {
      const double folds = Step(14.0, 22.0, p.z()) * Step(0.92, 0.7, e);
      const double wave = Sin(1.5 * p.z() + 0.02 * p.x() * p.x() + 0.5 * Sin(0.7 * p.x()));
      roof += 0.4 * folds * wave * Step(0.4, 2.0, std::abs(p.x()));
      roof -= 0.35 * Exp(-p.x() * p.x() / 0.5);  // the seam along the middle
    }
    const double lid = 0.85 * (p.y() - roof);
    const double rim = 0.9 * (e - 1.0) * arch.half_width;
    return SmoothMax(SmoothMax(lid, rim, 1.0), std::max(bottom + 1.0 - p.y(), -p.z() - 9.0), 1.5);
  };
}

}  // namespace

TriangleMesh MakeJaw(bool upper) {
  const ArchAxes arch = ArchOf(upper);
  constexpr double kBottom = -17.0;
  const Field gum = GumField(upper);
  const Field below = UnionOf({RidgeField(arch, kBottom), VaultField(arch, upper, kBottom)}, 3.0);
  const Field jaw = [=](const Vec3& p) { return SmoothMin(gum(p), below(p), 2.2); };
  const double x = arch.half_width + 11.0;
  const Eigen::AlignedBox3d box(Vec3(-x, kBottom - 2.0, -14.0), Vec3(x, 6.0, arch.length + 11.0));
  return SoftMesh(jaw, box, 0.75, 0.026);
}

TriangleMesh MakeTongue(double length) {
  const double l = 1e3 * length / 60.0;  // the shape is modelled 60 mm long
  const Field body = UnionOf(
      {EllipsoidField({0, -4, -13}, {20, 12, 18}), EllipsoidField({0, -1.5, 4}, {18.5, 8, 20}),
       EllipsoidField({0, -1.5, 18}, {14, 5.5, 13})},
      8.0);
  const Field tongue = [=](const Vec3& drawn) {
    const Vec3 p = drawn / l;
    const double upwards = std::clamp((p.y() + 2) / 4, 0., 1.);
    const double groove = 1.5 * Exp(-p.x() * p.x() / 6.0) * upwards;
    return l * (body(p) + groove * std::clamp((28.0 - p.z()) / 12.0, 0.0, 1.0));
  };
  const Eigen::AlignedBox3d box(Vec3(-23, -20, -35) * l, Vec3(23, 10, 34) * l);
  return SoftMesh(tongue, box, 1.2 * l, 0.03);
}

TriangleMesh MakeFace(double mouth_width, double mouth_height) {
  const double half_width = 500.0 * mouth_width;
  const double half_height = 500.0 * mouth_height;
  const Field skin = EllipsoidField({0, 0, -46}, {100, 88, 60});
  const Field cavity = EllipsoidField({0, 0, -34}, {38, 36, 46});
  // The lips: a roll round the mouth, fuller below, with a bow above.
  std::vector<Vec3> rim;
  for (int i = 0; i <= 96; ++i) {
    const double a = 2.0 * std::numbers::pi * i / 96;
    const double x = (half_width + 5.0) * Cos(a);
    const double bow = a < std::numbers::pi ? 1.6 * Exp(-x * x / 14.0) : 0.0;
    rim.emplace_back(x, (half_height + 5.0) * Sin(a) - bow, 11.0 - 0.011 * x * x);
  }
  constexpr double kLips = 5.2;
  constexpr double kBlend = 5.0;
  const Field lips = RopeField(rim, kLips);
  Eigen::AlignedBox3d near;  // the lips are at least as far as this box
  for (const Vec3& v : rim) near.extend(v);
  const Field uvula = ConeField({0, 26, -68}, 4.0, {0, 9, -66}, 2.6);
  const Field face = [=](const Vec3& p) {
    const double e = Length(p.x() / half_width, p.y() / half_height);
    const double aperture =
        SmoothMax((e - 1.0) * std::min(half_width, half_height), -25.0 - p.z(), 6.0);
    // The furrow under the nose (philtrum).
    const double furrow =
        1.3 * Exp(-p.x() * p.x() / 12.0) * Step(half_height + 3.0, half_height + 9.0, p.y());
    double flesh = skin(p) + furrow;
    flesh = SmoothMax(flesh, -cavity(p), 3.0);
    flesh = SmoothMax(flesh, -aperture, 4.0);
    if (!FarAbove(near.exteriorDistance(p) - kLips, flesh, kBlend)) {
      flesh = SmoothMin(flesh, lips(p), kBlend);
    }
    return SmoothMin(flesh, uvula(p), 3.0);
  };
  return SoftMesh(face, {Vec3(-104, -92, -110), Vec3(104, 92, 20)}, 2.2, 0.045);
}

}  // namespace palpate
