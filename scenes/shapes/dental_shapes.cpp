#include "scenes/shapes/dental_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/math/elementary.h"
#include "scenes/mesh/mesh_simplify.h"
#include "scenes/shapes/implicit_mesh.h"
#include "scenes/shapes/swept_mesh.h"
#include "scenes/shapes/tooth_forms.h"

namespace palpate {
namespace {

// All below is in millimetres, as usual in dentistry, and scaled at the end.
constexpr double kMillimetre = 1e-3;

TriangleMesh InMetres(TriangleMesh mesh) {
  for (Vec3& v : mesh.vertices) v *= kMillimetre;
  return mesh;
}

ToothSize InMillimetres(const ToothSize& s) {
  return {s.width / kMillimetre, s.depth / kMillimetre, s.crown / kMillimetre,
          s.root / kMillimetre};
}

Eigen::AlignedBox3d Box(double x, double y_min, double y_max, double z_min, double z_max) {
  return {Vec3(-x, y_min, z_min), Vec3(x, y_max, z_max)};
}

/// The crown's half width by height: at the neck, at the bulge, at the top.
struct Outline {
  double neck, bulge, top;
  double At(double s) const {
    constexpr double kBulge = 0.45;
    if (s < kBulge) {
      return neck + (bulge - neck) * Sin(0.5 * std::numbers::pi * std::clamp(s / kBulge, 0.0, 1.0));
    }
    const double t = (s - kBulge) / (1.0 - kBulge);
    return std::max(bulge + (top - bulge) * t * t, 0.5 * top);
  }
};

struct CrownShape {
  Outline along, across;
  double squareness;                         ///< exponent of the superellipse
  double rim;                                ///< height without cusps, as a share of the crown's
  double cusp_width;                         ///< as a share of the crown's width
  std::vector<std::array<double, 2>> cusps;  ///< x, z in half widths and half depths
};

const CrownShape& ShapeOf(ToothKind kind) {
  static const CrownShape kShapes[] = {
      {{0.68, 0.92, 1.0}, {0.85, 1.0, 0.16}, 2.6, 0.97, 0.2, {{-0.6, 0}, {0, 0}, {0.6, 0}}},
      {{0.7, 1.0, 0.55}, {0.85, 1.0, 0.3}, 2.3, 0.66, 0.22, {{0, 0.05}}},
      {{0.7, 1.0, 0.85}, {0.8, 1.0, 0.78}, 2.4, 0.62, 0.2, {{0, 0.5}, {0, -0.5}}},
      {{0.78, 1.0, 0.92},
       {0.8, 1.0, 0.84},
       3.0,
       0.64,
       0.16,
       {{0.52, 0.5}, {-0.52, 0.5}, {0.5, -0.5}, {-0.5, -0.5}}}};
  return kShapes[static_cast<int>(kind)];
}

ToothNumber NumberOfKind(ToothKind kind) {
  return NumberOf(std::size_t(kind) - std::size_t(ToothKind::kFirstByNumber));
}
ToothMeasures InTable(const ToothSize& size) {
  return {size.width, size.depth, size.crown, size.root};
}

/// Returns the field of a tooth whose size is in mm.
Field ToothField(ToothKind kind, const ToothSize& size) {
  if (kind >= ToothKind::kFirstByNumber) return ToothFormField(NumberOfKind(kind), InTable(size));
  const CrownShape& shape = ShapeOf(kind);
  const double half_width = 0.5 * size.width;
  const double half_depth = 0.5 * size.depth;
  const Field crown = [=](const Vec3& p) {
    const double s = p.y() / size.crown;
    const double a = half_width * shape.along.At(s);
    const double b = half_depth * shape.across.At(s);
    const double n = shape.squareness;
    const double r = Pow(Pow(std::abs(p.x()) / a, n) + Pow(std::abs(p.z()) / b, n), 1.0 / n);
    const double side = (r - 1.0) * std::min(a, b);
    double top = shape.rim * size.crown;
    const double sigma = shape.cusp_width * size.width;
    for (const auto& [x, z] : shape.cusps) {
      const double dx = p.x() - x * half_width;
      const double dz = p.z() - z * half_depth;
      top += (1.0 - shape.rim) * size.crown * Exp(-0.5 * (dx * dx + dz * dz) / (sigma * sigma));
    }
    const double lid = 0.75 * (p.y() - top);
    return SmoothMax(SmoothMax(side, lid, 1.0), -(p.y() + 1.5), 1.0);
  };
  std::vector<Field> parts{crown};
  if (kind == ToothKind::kMolar) {
    parts.push_back(EllipsoidField({0, -1.5, 0}, {0.4 * size.width, 3.2, 0.4 * size.depth}));
    for (const double side : {-1.0, 1.0}) {  // flattened: wider across the arch than along it
      const Field root = ConeField({side * 0.22 * size.width, -1.0, 0}, 0.19 * size.width,
                                   {side * 0.3 * size.width, -size.root + 1.0, 0}, 1.0);
      parts.push_back([=](const Vec3& p) {
        const double down = std::min(p.y(), 0.0) / size.root;
        const double bend = 1.2 * side * down * down;
        return root({p.x() + bend, p.y(), 0.62 * p.z()});
      });
    }
  } else {
    const double flat = size.width / size.depth;
    const Field root = ConeField({0, -0.5, 0}, 0.35 * size.width, {0, -size.root + 0.8, 0}, 0.8);
    parts.push_back([=](const Vec3& p) {
      return root({p.x(), p.y(), (0.3 + 0.7 * flat) * p.z()});
    });
  }
  return UnionOf(std::move(parts), 1.6);
}

Eigen::AlignedBox3d ToothBox(const ToothSize& size, double margin) {
  return Box(0.5 * size.width + margin, -size.root - margin, size.crown + margin,
             -0.5 * size.depth - margin, 0.5 * size.depth + margin);
}

/// Returns a number from -1 to 1 at an integer lattice point, from the bits of a hash.
double AtLattice(int i, int j, int k) {
  std::uint32_t h = std::uint32_t(i) * 0x8da6b343u ^ std::uint32_t(j) * 0xd8163841u ^
                    std::uint32_t(k) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return double(h >> 8) / double(1u << 23) - 1.0;
}

/// Returns smooth noise from -1 to 1 whose grains are about 1 wide: random numbers at lattice
/// points, blended between them (Perlin, "An image synthesizer", SIGGRAPH 1985, as value noise).
double Noise(const Vec3& p) {
  const Eigen::Vector3i cell = p.array().floor().cast<int>();
  const Vec3 t = p - cell.cast<double>();
  const Vec3 w = t.cwiseProduct(t).cwiseProduct(Vec3::Constant(3.0) - 2.0 * t);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    Eigen::Vector3i at = cell;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (corner >> axis & 1) != 0;
      weight *= upper ? w[axis] : 1.0 - w[axis];
      at[axis] += upper;
    }
    sum += weight * AtLattice(at.x(), at.y(), at.z());
  }
  return sum;
}

/// Makes an instrument along a polyline from the tip on, rounded at its corners, with radii.
TriangleMesh Instrument(const std::vector<Vec3>& corners, const std::vector<double>& radii,
                        double step) {
  std::vector<Vec3> curve;
  std::vector<double> thickness;
  // Cubic Hermite pieces.  The direction at a corner is that between its neighbours, as in
  // Catmull-Rom splines, but as long as each piece, so that a short piece beside a long one
  // does not overshoot.
  const auto direction = [&](std::size_t i) {
    const Vec3& before = corners[i == 0 ? 0 : i - 1];
    const Vec3& after = corners[std::min(i + 1, corners.size() - 1)];
    return (after - before).normalized();
  };
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[i + 1];
    const double length = (b - a).norm();
    const int pieces = std::max(1, int(std::lround(length / step)));
    for (int k = 0; k < pieces; ++k) {
      const double t = double(k) / pieces;
      const double u = 1.0 - t;
      curve.push_back(u * u * (1.0 + 2.0 * t) * a + t * t * (1.0 + 2.0 * u) * b +
                      length * t * u * (u * direction(i) - t * direction(i + 1)));
      thickness.push_back(radii[i] + t * (radii[i + 1] - radii[i]));
    }
  }
  curve.push_back(corners.back());
  thickness.push_back(radii.back());
  // Round ends: rings of half a ball before the first and after the last point.
  const Vec3 front = (curve[0] - curve[1]).normalized();
  const Vec3 back = (curve.back() - curve[curve.size() - 2]).normalized();
  const double r0 = thickness.front();
  const double r1 = thickness.back();
  const Vec3 first = curve.front();
  const Vec3 last = curve.back();
  for (const double a : {0.35, 0.7, 1.05, 1.4}) {
    curve.insert(curve.begin(), first + r0 * Sin(a) * front);
    thickness.insert(thickness.begin(), r0 * Cos(a));
    curve.push_back(last + r1 * Sin(a) * back);
    thickness.push_back(r1 * Cos(a));
  }
  return MakeRod(curve, thickness, 16);
}

/// A gum whose size is in mm: the ridge above a jaw, what is removed from it, and what is left.
struct GumFields {
  Field block, hole, gum;
  Eigen::AlignedBox3d box;
};

Vec3 SlopeOf(const Field& field, const Vec3& p) {
  constexpr double kStep = 1e-3;
  Vec3 slope;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = kStep * Vec3::Unit(k);
    slope[k] = (field(p + e) - field(p - e)) / (2.0 * kStep);
  }
  return slope;
}

/// Returns the depth of a pocket that goes all round, towards a point [mm]; it varies
/// smoothly between sites.
double DepthTowards(const Vec3& p, const ToothSize& size, const std::array<double, 6>& sites,
                    double mesial) {
  // Clockwise seen from above if mesial is +x, from the middle outside on: the corners of a crown
  // are at 60 degrees of an ellipse.
  const double angle = Atan2(mesial * p.x() / size.width, p.z() / size.depth);
  const double at = std::fmod(angle / (std::numbers::pi / 3.0) + 6.0, 6.0);
  constexpr std::array<std::size_t, 6> kRound = {1, 0, 3, 4, 5, 2};
  const auto before = static_cast<std::size_t>(at) % 6;
  const double t = at - std::floor(at);
  const double a = sites[kRound[before]], b = sites[kRound[(before + 1) % 6]];
  return (a + (b - a) * t * t * (3.0 - 2.0 * t)) / kMillimetre;
}

GumFields FieldsOfGum(ToothKind kind, const ToothSize& metres, const GumSize& gum_metres) {
  const ToothSize size = InMillimetres(metres);
  const double depth = gum_metres.pocket_depth / kMillimetre;
  const double width = gum_metres.pocket_width / kMillimetre;
  const double x = 0.5 * size.width + 3.5;
  const double z = 0.5 * size.depth + 4.5;
  const double floor = -size.root - 2.0;
  const double margin = 0.8 - gum_metres.recession / kMillimetre;
  // A ridge with round shoulders whose top rises between the teeth, like papillae.
  const Field block = [=](const Vec3& p) {
    const double rise = 2.2 * Pow(std::min(std::abs(p.x()) / x, 1.0), 2.4);
    const double wall = std::abs(p.z()) - z - 0.06 * (margin - p.y());
    const double ridge = SmoothMax(wall, 0.95 * (p.y() - margin - rise), 7.0);
    return SmoothMax(SmoothMax(ridge, std::abs(p.x()) - x, 3.0), floor - p.y(), 2.0);
  };
  const Field tooth = ToothField(kind, size);
  const Field socket = [=](const Vec3& p) { return tooth(p) + 0.1; };  // the gum overlaps the tooth
  const double reach = 0.32 * size.width;
  const bool all_round = std::ranges::any_of(gum_metres.sites, [](double d) { return d > 0.0; });
  const double mesial =
      kind >= ToothKind::kFirstByNumber && NumberOfKind(kind).quadrant % 2 != 0 ? -1.0 : 1.0;
  // The tooth's field underestimates lengths along z, but the width must be right.
  const auto from_tooth = [=](const Vec3& p) {
    return tooth(p) / std::max(SlopeOf(tooth, p).norm(), 0.3);
  };
  // A lower bound of the pocket's field: the distance to its box.
  const auto beside = [=](const Vec3& p) {
    return all_round ? -2.0 * size.width : std::abs(p.x()) - reach;
  };
  const auto end = [=, sites = gum_metres.sites](const Vec3& p) {
    if (all_round) return -DepthTowards(p, size, sites, mesial) - p.y();
    return SmoothMax(-depth - p.y(), 0.15 * size.depth - p.z(), 0.6);
  };
  const Field pocket = [=](const Vec3& p) {
    return SmoothMax(SmoothMax(from_tooth(p) - width, beside(p), 0.8), end(p), 0.8);
  };
  const Field gripping = Without(block, socket, 0.4);
  const Field gum = [=](const Vec3& p) {
    const double solid = gripping(p);
    return FarAbove(std::max(beside(p), end(p)), -solid, 0.5) ? solid
                                                              : SmoothMax(solid, -pocket(p), 0.5);
  };
  return {block, [=](const Vec3& p) { return std::min(socket(p), pocket(p)); }, gum,
          Box(x + 1.0, floor - 1.5, 5.0, -z - 2.5, z + 2.5)};
}

}  // namespace

std::span<const std::string_view> ToothKindNames() {
  static const std::vector<std::string_view> kNames = [] {
    std::vector<std::string_view> names{"incisor", "canine", "premolar", "molar"};
    names.insert(names.end(), ToothNames().begin(), ToothNames().end());
    return names;
  }();
  return kNames;
}

ToothSize UsualSize(ToothKind kind) {
  if (kind >= ToothKind::kFirstByNumber) {
    const ToothMeasures mm = MeasuresOf(NumberOfKind(kind));
    return {1e-3 * mm.width, 1e-3 * mm.depth, 1e-3 * mm.crown, 1e-3 * mm.root};
  }
  switch (kind) {
    case ToothKind::kIncisor:
      return {0.0085, 0.007, 0.0105, 0.013};
    case ToothKind::kCanine:
      return {0.0075, 0.008, 0.010, 0.017};
    case ToothKind::kPremolar:
      return {0.007, 0.009, 0.0085, 0.014};
    default:
      return {0.0105, 0.0105, 0.0075, 0.013};
  }
}

TriangleMesh MakeTooth(ToothKind kind, const ToothSize& metres) {
  const ToothSize size = InMillimetres(metres);
  if (kind >= ToothKind::kFirstByNumber) return MakeToothForm(NumberOfKind(kind), InTable(size));
  return InMetres(MeshOfField(ToothField(kind, size), ToothBox(size, 1.5), size.width / 8.0));
}

TriangleMesh MakeDentine(ToothKind kind, const ToothSize& metres, double enamel) {
  const ToothSize size = InMillimetres(metres);
  const Field dentine = [=, tooth = ToothField(kind, size)](const Vec3& p) {
    constexpr double kBeyond = 0.1;  // four times the tolerance of the tooth's mesh
    const double s = std::clamp(p.y() / (0.85 * size.crown), 0.0, 1.0);
    return tooth(p) + enamel / kMillimetre * s * (2.0 - s) - kBeyond;
  };
  return InMetres(Simplified(MeshOfField(dentine, ToothBox(size, 2.0), 0.55), 0.025));
}

TriangleMesh MakeGingiva(ToothKind kind, const ToothSize& size, const GumSize& gum) {
  const GumFields fields = FieldsOfGum(kind, size, gum);
  constexpr double kCell = 0.7;  // half of the pocket's width
  return InMetres(Simplified(MeshOfField(fields.gum, fields.box, kCell), 0.015));
}

std::vector<Vec3> GingivalMargin(ToothKind kind, const ToothSize& size, const GumSize& gum) {
  const GumFields fields = FieldsOfGum(kind, size, gum);
  constexpr int kPoints = 96;
  constexpr double kStep = 0.25;
  const double most = fields.box.sizes().maxCoeff();
  std::vector<Vec3> margin;
  for (int i = 0; i < kPoints; ++i) {
    // From +z towards +x: counter-clockwise seen from +y.
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    const Vec3 outwards(Sin(angle), 0.0, Cos(angle));
    // Find the edge of the hole at a height, from inside.
    const auto edge_at = [&](double y) {
      const auto at = [&](double r) { return Vec3(r * outwards + y * Vec3::UnitY()); };
      double r = 0.0;
      while (r < most && fields.hole(at(r)) < 0.0) r += kStep;
      double inside = std::max(0.0, r - kStep);
      for (int k = 0; k < 6; ++k) {
        const double middle = 0.5 * (inside + r);
        (fields.hole(at(middle)) < 0.0 ? inside : r) = middle;
      }
      return at(r);
    };
    // Search along it, down to where the block begins.
    double low = fields.box.min().y();
    double high = fields.box.max().y();
    for (int k = 0; k < 12; ++k) {
      const double middle = 0.5 * (low + high);
      (fields.block(edge_at(middle)) < 0.0 ? low : high) = middle;
    }
    Vec3 edge = edge_at(low);
    // The seam of both is rounded.
    for (int k = 0; k < 3; ++k) {
      const Vec3 slope = SlopeOf(fields.gum, edge);
      edge -= fields.gum(edge) / slope.squaredNorm() * slope;
    }
    margin.push_back(kMillimetre * edge);
  }
  return margin;
}

TriangleMesh MakeCalculus(ToothKind kind, const ToothSize& metres, double across) {
  const ToothSize size = InMillimetres(metres);
  const double r = 0.5 * across / kMillimetre;
  const Field tooth = ToothField(kind, size);
  const double y = 0.3 * size.crown;
  double surface = 0.0;  // z of the tooth's outer side at that height
  while (tooth({0, y, surface}) < 0.0) surface += 0.01;
  const Field lump = [=](const Vec3& p) {
    // Grains on lumps, and a frayed rim.
    const double lumps = Noise(1.3 * p);
    const double grains = Noise(3.1 * p + Vec3(7.3, 1.9, 4.1));
    const double e = Length(p.x(), p.y() - y) / r + 0.16 * lumps;
    // A crust that thins towards its rim, with a little of it inside the tooth.
    const double thickness = 0.5 * (1.0 - e * e) + 0.2 * lumps + 0.12 * grains;
    return SmoothMax(SmoothMax(tooth(p) - thickness, r * (e - 1.1), 0.4),
                     SmoothMax(-(tooth(p) + 0.6), -(p.z() - surface + 2.5), 0.3), 0.3);
  };
  return InMetres(MeshOfField(
      lump, Box(r + 1.5, y - r - 1.5, y + r + 1.5, surface - 4.0, surface + 2.5), r / 10.0));
}

TriangleMesh MakeMandible(JawPart part, double length, double cortex) {
  const double half = 0.5 * length / kMillimetre, within = cortex / kMillimetre;
  constexpr double kHalfHeight = 8.0, kHalfThickness = 5.0, kBend = 45.0, kBeyond = 1.0;
  // A section is egg-shaped, and thicker at the lower border.
  const auto section = [](const Vec3& p) {
    const double y = p.y() / kHalfHeight,
                 z = (p.z() + p.x() * p.x() / (2.0 * kBend)) / (kHalfThickness * (1.0 - 0.14 * y));
    return (Pow(Pow(std::abs(y), 2.6) + Pow(std::abs(z), 2.6), 1.0 / 2.6) - 1.0) * kHalfThickness;
  };
  const Field bone = [=](const Vec3& p) {
    return SmoothMax(section(p), std::abs(p.x()) - half, 0.6);
  };
  const Field marrow = [=](const Vec3& p) {
    return SmoothMax(section(p) + within, std::abs(p.x()) - half - kBeyond, 0.6);
  };
  std::vector<Vec3> canal;
  for (double x = -half - kBeyond; x <= half + kBeyond; x += 1.0) {
    canal.emplace_back(x, -3.4 - 0.01 * x * x, -0.8 - x * x / (2.0 * kBend));
  }
  const Field field = part == JawPart::kBone     ? bone
                      : part == JawPart::kMarrow ? marrow
                                                 : RopeField(canal, 1.3);
  const auto box = Box(half + 4.0, -10.0, 10.0, -kHalfThickness - 2.0 - half * half / (2.0 * kBend),
                       kHalfThickness + 2.0);
  const double cell = part == JawPart::kNerve ? 0.4 : 0.6;
  return InMetres(Simplified(MeshOfField(field, box, cell), 0.02));
}

TriangleMesh MakeProbe(double tip_radius, double length) {
  const double r = tip_radius / kMillimetre;
  const double l = length / kMillimetre;
  return InMetres(Instrument({{0, r, 0},
                              {0, 4, 0},
                              {0, 9, 0},
                              {0, 13, 1.2},
                              {0, 18, 7},
                              {0, 24, 12},
                              {0, 30, 14.5},
                              {0, l - 2.0, 14.5 + 0.2 * (l - 30.0)},
                              {0, l, 14.9 + 0.2 * (l - 30.0)}},
                             {r, 1.2 * r, 1.5 * r, 1.8 * r, 2.2 * r, 1.1, 1.6, 2.2, 2.0}, 1.5));
}

TriangleMesh MakeScaler(double tip_radius, double length) {
  const double r = tip_radius / kMillimetre;
  const double l = length / kMillimetre;
  return InMetres(Instrument({{0, 0, -3.6},
                              {0, 0.5, -2.2},
                              {0, 2.0, -0.6},
                              {0, 4.5, 0.2},
                              {0, 9, 0.6},
                              {0, 14, 3.4},
                              {0, 20, 7.5},
                              {0, 27, 9.5},
                              {0, l - 2.0, 9.5 + 0.2 * (l - 27.0)},
                              {0, l, 9.9 + 0.2 * (l - 27.0)}},
                             {r, 1.5 * r, 1.9 * r, 2.2 * r, 2.6 * r, 1.0, 1.2, 1.7, 2.3, 2.1},
                             1.0));
}

TriangleMesh MakeMirror(double diameter, double length) {
  const double r = 0.5 * diameter / kMillimetre;
  const double l = length / kMillimetre;
  return InMetres(Instrument({{0, 0, 0},
                              {0, 0, 0.6},
                              {0, 0, 1.2},
                              {0, 0.2, 2.4},
                              {0, 4, 6},
                              {0, 18, 10},
                              {0, 30, 12},
                              {0, l - 2.0, 12 + 0.1 * (l - 30.0)},
                              {0, l, 12.2 + 0.1 * (l - 30.0)}},
                             {r - 0.6, r, r - 0.6, 1.2, 1.1, 1.1, 1.6, 2.2, 2.0}, 0.6));
}

}  // namespace palpate
