#include "scenes/dental_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scenes/implicit_mesh.h"
#include "scenes/swept_mesh.h"

namespace palpate {
namespace {

// Everything below is in millimetres, the unit of the trade, and scaled last.
constexpr double kMillimetre = 1e-3;
constexpr double kPi = 3.14159265358979323846;

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

/// How the crown's half width changes with height: at the neck, at the bulge, at the top.
struct Outline {
  double neck, bulge, top;
  double At(double s) const {
    constexpr double kBulge = 0.45;
    if (s < kBulge) {
      return neck + (bulge - neck) * std::sin(0.5 * kPi * std::clamp(s / kBulge, 0.0, 1.0));
    }
    const double t = (s - kBulge) / (1.0 - kBulge);
    return std::max(bulge + (top - bulge) * t * t, 0.5 * top);
  }
};

struct CrownShape {
  Outline along, across;
  double squareness;                         ///< exponent of the superellipse
  double rim;                                ///< height without cusps, of the crown's
  double cusp_width;                         ///< of the crown's width
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

/// A tooth of a size in mm.
Field ToothField(ToothKind kind, const ToothSize& size) {
  const CrownShape& shape = ShapeOf(kind);
  const double half_width = 0.5 * size.width;
  const double half_depth = 0.5 * size.depth;
  const Field crown = [=](const Vec3& p) {
    const double s = p.y() / size.crown;
    const double a = half_width * shape.along.At(s);
    const double b = half_depth * shape.across.At(s);
    const double n = shape.squareness;
    const double r =
        std::pow(std::pow(std::abs(p.x()) / a, n) + std::pow(std::abs(p.z()) / b, n), 1.0 / n);
    const double side = (r - 1.0) * std::min(a, b);
    double top = shape.rim * size.crown;
    const double sigma = shape.cusp_width * size.width;
    for (const auto& [x, z] : shape.cusps) {
      const double dx = p.x() - x * half_width;
      const double dz = p.z() - z * half_depth;
      top +=
          (1.0 - shape.rim) * size.crown * std::exp(-0.5 * (dx * dx + dz * dz) / (sigma * sigma));
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
        const double bend = 1.2 * side * std::pow(std::min(p.y(), 0.0) / size.root, 2.0);
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

/// Points on a half ellipse from the right end over the front to the left.
std::vector<Vec3> ArchCurve(const Arch& arch) {
  constexpr int kSteps = 40;
  std::vector<Vec3> curve;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = kPi * i / kSteps;
    curve.emplace_back(arch.half_width * std::cos(a), 0.0, arch.length * std::sin(a));
  }
  return curve;
}

/// Curve of an instrument from the tip on, rounded at the corners of a polyline, with radii.
TriangleMesh Instrument(const std::vector<Vec3>& corners, const std::vector<double>& radii,
                        double step) {
  std::vector<Vec3> curve;
  std::vector<double> thickness;
  // Cubic Hermite pieces; the direction at a corner is that between its neighbours, as Catmull and
  // Rom have it, as long as each piece, so that a short piece beside a long one does not overshoot.
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
  // Round ends: half a ball of rings before the first and after the last point.
  const Vec3 front = (curve[0] - curve[1]).normalized();
  const Vec3 back = (curve.back() - curve[curve.size() - 2]).normalized();
  const double r0 = thickness.front();
  const double r1 = thickness.back();
  const Vec3 first = curve.front();
  const Vec3 last = curve.back();
  for (const double a : {0.35, 0.7, 1.05, 1.4}) {
    curve.insert(curve.begin(), first + r0 * std::sin(a) * front);
    thickness.insert(thickness.begin(), r0 * std::cos(a));
    curve.push_back(last + r1 * std::sin(a) * back);
    thickness.push_back(r1 * std::cos(a));
  }
  return MakeRod(curve, thickness, 16);
}

}  // namespace

ToothSize UsualSize(ToothKind kind) {
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
  return InMetres(MeshOfField(ToothField(kind, size), ToothBox(size, 1.5), size.width / 8.0));
}

TriangleMesh MakeGingiva(ToothKind kind, const ToothSize& metres, double pocket_depth,
                         double pocket_width) {
  const ToothSize size = InMillimetres(metres);
  const double depth = pocket_depth / kMillimetre;
  const double width = pocket_width / kMillimetre;
  const double x = 0.5 * size.width + 3.5;
  const double z = 0.5 * size.depth + 4.5;
  const double floor = -size.root - 2.0;
  constexpr double kRound = 2.5;
  // A block whose top rises between the teeth, as the papillae do.
  const Field block = [=](const Vec3& p) {
    const double rise = 1.4 * std::pow(std::min(std::abs(p.x()) / x, 1.0), 2.0);
    const Vec3 half(x - kRound, 0.5 * (0.8 - floor) - kRound, z - kRound);
    const Vec3 q = Vec3(p.x(), p.y() - rise - 0.5 * (0.8 + floor), p.z()).cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - kRound;
  };
  const Field tooth = ToothField(kind, size);
  const Field socket = [=](const Vec3& p) { return tooth(p) + 0.1; };  // gum grips the tooth
  const double reach = 0.32 * size.width;
  // The tooth's field counts lengths along z short; here the width matters.
  const auto from_tooth = [=](const Vec3& p) {
    constexpr double kStep = 1e-3;
    Vec3 slope;
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = kStep * Vec3::Unit(k);
      slope[k] = (tooth(p + e) - tooth(p - e)) / (2.0 * kStep);
    }
    return tooth(p) / std::max(slope.norm(), 0.3);
  };
  const Field pocket = [=](const Vec3& p) {
    const double beside = std::abs(p.x()) - reach;
    const double below = -depth - p.y();
    const double behind = 0.15 * size.depth - p.z();
    return SmoothMax(SmoothMax(from_tooth(p) - width, beside, 0.8), SmoothMax(below, behind, 0.6),
                     0.8);
  };
  const Field gum = Without(Without(block, socket, 0.4), pocket, 0.5);
  return InMetres(
      MeshOfField(gum, Box(x + 1.0, floor - 1.5, 4.0, -z - 1.0, z + 1.0), size.width / 8.5));
}

TriangleMesh MakeCalculus(ToothKind kind, const ToothSize& metres, double across) {
  const ToothSize size = InMillimetres(metres);
  const double r = 0.5 * across / kMillimetre;
  const Field tooth = ToothField(kind, size);
  const double y = 0.3 * size.crown;
  double surface = 0.0;  // z of the tooth's outer side at that height
  while (tooth({0, y, surface}) < 0.0) surface += 0.01;
  const Field lump = [=](const Vec3& p) {
    const double rough = 0.06 * std::sin(5.1 * p.x()) * std::sin(4.3 * p.y() + 1.0) +
                         0.03 * std::sin(9.0 * p.x() + 2.0) * std::sin(8.1 * p.y());
    // A crust that thins out towards its rim, a little of it inside the tooth.
    const double e = std::hypot(p.x(), p.y() - y) / r;
    const double thickness = 0.5 * (1.0 - e * e) + rough;
    return SmoothMax(SmoothMax(tooth(p) - thickness, r * (e - 1.1), 0.4),
                     SmoothMax(-(tooth(p) + 0.6), -(p.z() - surface + 2.5), 0.3), 0.3);
  };
  return InMetres(MeshOfField(
      lump, Box(r + 1.0, y - r - 1.0, y + r + 1.0, surface - 4.0, surface + 2.0), r / 8.0));
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

Arch UsualArch(bool upper) {
  return upper ? Arch{0.025, 0.045} : Arch{0.0235, 0.043};
}

TriangleMesh MakeJaw(bool upper) {
  const Arch metres = UsualArch(upper);
  const Arch arch{metres.half_width / kMillimetre, metres.length / kMillimetre};
  const std::vector<Vec3> curve = ArchCurve(arch);
  const Field distance = RopeField(curve, 0.0);
  constexpr double kDeep = 17.0;
  constexpr double kRound = 3.0;
  const Field ridge = [=](const Vec3& p) {
    const double d = distance({p.x(), 0.0, p.z()});
    const double half = 6.2 + 0.1 * std::max(-p.y(), 0.0);  // wider below
    const double qx = d - (half - kRound);
    const double qy = std::abs(p.y() + 0.5 * kDeep) - (0.5 * kDeep - kRound);
    return std::hypot(std::max(qx, 0.0), std::max(qy, 0.0)) + std::min(std::max(qx, qy), 0.0) -
           kRound;
  };
  // One socket for each tooth, every fourteenth of the arch.
  std::vector<Field> sockets;
  const double quarter = double(curve.size() - 1);
  double whole = 0.0;
  for (std::size_t i = 1; i < curve.size(); ++i) whole += (curve[i] - curve[i - 1]).norm();
  for (int tooth = 0; tooth < 14; ++tooth) {
    double left = whole * (tooth + 0.5) / 14.0;
    std::size_t i = 1;
    while (i < std::size_t(quarter) && left > (curve[i] - curve[i - 1]).norm()) {
      left -= (curve[i] - curve[i - 1]).norm();
      ++i;
    }
    const Vec3 along = (curve[i] - curve[i - 1]).normalized();
    const Vec3 at = curve[i - 1] + left * along;
    sockets.push_back(EllipsoidField(at, {2.9, 3.2, 2.9}));
  }
  Field jaw = Without(ridge, UnionOf(sockets, 0.3), 0.8);
  if (upper) {
    const Field palate = [=](const Vec3& p) {
      const double e = std::hypot(p.x() / arch.half_width, p.z() / arch.length);
      const double vault = -13.0 + 8.0 * e * e;
      return std::max({std::abs(p.y() - vault) - 1.6, (e - 1.0) * arch.half_width, -p.z() - 2.0});
    };
    jaw = UnionOf({jaw, palate}, 1.5);
  }
  return InMetres(
      MeshOfField(jaw, Box(arch.half_width + 10, -kDeep - 2, 2, -10, arch.length + 10), 3.0));
}

TriangleMesh MakeTongue(double length) {
  const double l = length / kMillimetre / 60.0;  // drawn 60 mm long
  const Field body =
      UnionOf({EllipsoidField({0, -3, -12}, {18, 11, 18}), EllipsoidField({0, 0, 2}, {16, 7, 20}),
               EllipsoidField({0, 1.5, 18}, {11, 4.5, 12})},
              8.0);
  const Field tongue = [=](const Vec3& drawn) {
    const Vec3 p = drawn / l;
    const double groove =
        1.6 * std::exp(-p.x() * p.x() / 5.0) * std::clamp((p.y() + 2) / 4, 0., 1.);
    return l * (body(p) + groove * std::clamp((28.0 - p.z()) / 12.0, 0.0, 1.0));
  };
  return InMetres(MeshOfField(tongue, Box(21 * l, -17 * l, 10 * l, -33 * l, 33 * l), 2.8 * l));
}

TriangleMesh MakeFace(double mouth_width, double mouth_height) {
  const double half_width = 0.5 * mouth_width / kMillimetre;
  const double half_height = 0.5 * mouth_height / kMillimetre;
  constexpr double kThick = 8.0;
  const Field head = EllipsoidField({0, 25, -75}, {76, 112, 88});
  std::vector<Vec3> lips;
  for (int i = 0; i <= 32; ++i) {
    const double a = 2.0 * kPi * i / 32;
    const double x = (half_width + 3.0) * std::cos(a);
    lips.emplace_back(x, (half_height + 3.0) * std::sin(a), 12.0 - 0.006 * x * x);
  }
  const auto pair = [](std::vector<Field>& to, auto make) {
    to.push_back(make(-1.0));
    to.push_back(make(1.0));
  };
  std::vector<Field> front{head, EllipsoidField({0, -half_height - 24, 1}, {20, 14, 13}),  // chin
                           ConeField({0, 74, 10}, 6, {0, half_height + 22, 30}, 8.5),      // nose
                           RopeField(lips, 4.2)};
  pair(front, [&](double s) {  // wings of the nose
    return EllipsoidField({9.5 * s, half_height + 21, 20}, {6, 6, 8});
  });
  pair(front, [](double s) {  // cheekbones
    return EllipsoidField({43 * s, 38, -16}, {22, 16, 18});
  });
  pair(front, [](double s) {  // brows
    return ConeField({14 * s, 82, 9}, 5, {44 * s, 79, -5}, 4.5);
  });
  std::vector<Field> hollows;
  pair(hollows, [](double s) { return EllipsoidField({31 * s, 65, 14}, {16, 10, 12}); });
  pair(hollows, [&](double s) {  // nostrils
    return EllipsoidField({5 * s, half_height + 14, 24}, {2.6, 5, 3.6});
  });
  const Field skin = UnionOf({Without(UnionOf(front, 11.0), UnionOf(hollows, 2.0), 5.0),
                              EllipsoidField({31, 65, -3}, {12, 10.5, 12}),  // eyes
                              EllipsoidField({-31, 65, -3}, {12, 10.5, 12})},
                             1.0);
  const Field inside = [=](const Vec3& p) { return head(p) + kThick; };
  const Field mouth = EllipsoidField({0, 0, 8}, {half_width, half_height, 60});
  const Field mask = [=](const Vec3& p) {
    const double shell = SmoothMax(skin(p), -inside(p), 2.0);
    return SmoothMax(SmoothMax(shell, -mouth(p), 3.0), -(p.z() + 60.0), 3.0);
  };
  return InMetres(MeshOfField(mask, Box(84, -96, 145, -68, 45), 6.0));
}

}  // namespace palpate
