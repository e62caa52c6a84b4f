#include "scenes/grid/bur.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "scenes/mesh/figure.h"

namespace palpate {
namespace {

/// Number of segments in which an arc or a line of the curve is sampled.  A quarter circle of that
/// many chords is 2.5e-5 shorter than the arc.
constexpr int kPieces = 64;
/// Cosine and sine of the golden angle, pi (3 - sqrt(5)).
constexpr double kGoldenCos = -0.73736887807831990, kGoldenSin = 0.67549029426152364;

void Require(bool holds, const std::string& what) {
  if (!holds) throw Error("bur: " + what);
}

std::string Millimetres(double metres) {
  return Figure(1e3 * metres, 4) + " mm";
}

}  // namespace

Bur Bur::Ball(double radius) {
  return Bur({{0.0, 0.0}}, radius);
}

Bur Bur::Cylinder(double radius, double length, double rounding) {
  return Cone(radius, radius, length, rounding);
}

Bur Bur::Cone(double tip_radius, double base_radius, double length, double rounding) {
  Require(
      rounding >= 0.0 && rounding <= std::min(tip_radius, base_radius) && 2.0 * rounding < length,
      "a rounding of " + Millimetres(rounding) + " is not allowed; give at most its radius, " +
          Millimetres(std::min(tip_radius, base_radius)) + ", and less than half its length");
  const double top = length - 2.0 * rounding;
  std::vector<std::array<double, 2>> curve{{0.0, 0.0}};
  if (tip_radius > rounding) curve.push_back({tip_radius - rounding, 0.0});
  if (base_radius > rounding) curve.push_back({base_radius - rounding, top});
  curve.push_back({0.0, top});
  return Bur(curve, rounding);
}

Bur::Bur(const std::vector<std::array<double, 2>>& curve, double rounding) : rounding_(rounding) {
  Require(!curve.empty() && curve.size() <= kMostPoints,
          "a curve of " + std::to_string(curve.size()) + " points is not allowed; give 1 to " +
              std::to_string(kMostPoints));
  const bool hollow = curve.size() > 1 && curve.front() == curve.back() && curve[0][0] != 0.0;
  Require(
      hollow || (curve.front()[0] == 0.0 && curve.back()[0] == 0.0),
      "its curve has to begin and to end on the axis, at radius 0, or to end where it began, as "
      "a trephine's wall");
  count_ = static_cast<int>(curve.size());
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const auto& [rho, z] = curve[i];
    Require(std::isfinite(z) && rho >= 0.0 && std::isfinite(rho),
            "point " + std::to_string(i) + " of its curve has to be finite, of a radius >= 0");
    points_[i] = {rho, z};
    reach_ = std::max(reach_, std::sqrt(rho * rho + z * z) + rounding);
    radius_ = std::max(radius_, rho + rounding);
    high_ = std::max(high_, z + rounding);
    if (i == 0) continue;
    const double along = rho - points_[i - 1].rho, up = z - points_[i - 1].z;
    const double length = std::sqrt(along * along + up * up);
    Require(length > 0.0, "point " + std::to_string(i) +
                              " of its curve is the one before; "
                              "leave it out");
    normals_[i - 1] = {up / length, -along / length};
    inverse_squared_[i - 1] = 1.0 / (length * length);
    if (i == 1) continue;
    RequireConvex(i - 2, i - 1);
  }
  if (hollow) {
    RequireConvex(curve.size() - 2, 0);
    bore_ = std::ranges::min(curve)[0] - rounding;
    Require(bore_ > 0.0, "its wall leaves no bore; give a thinner one, or a greater diameter");
  }
  Require(rounding >= 0.0 && std::isfinite(rounding) && radius_ > 0.0,
          "a radius of " + Millimetres(radius_) + " is not allowed; give one above 0");
}

/// Throws Error unless the curve is convex between two consecutive segments.
void Bur::RequireConvex(std::size_t a, std::size_t b) const {
  Require(normals_[a].rho * normals_[b].z > normals_[a].z * normals_[b].rho,
          "its curve is not convex at point " + std::to_string(b) +
              "; give the points of its hull, from the tip outwards");
}

double Bur::Distance(const Vec3& p_T, Vec3& gradient_T) const noexcept {
  const double rho = std::sqrt(p_T.x() * p_T.x() + p_T.y() * p_T.y()), z = p_T.z();
  // Inside the curve, the nearest segment is the one with the least depth; outside, take the
  // nearest point of all segments.
  double distance = count_ == 1 ? 0.0 : -1e300;
  Point normal{1.0, 0.0};
  for (std::size_t n = 0; n + 1 < static_cast<std::size_t>(count_); ++n) {
    const double above =
        (rho - points_[n].rho) * normals_[n].rho + (z - points_[n].z) * normals_[n].z;
    if (above > distance) {
      distance = above;
      normal = normals_[n];
    }
  }
  if (distance >= 0.0) {
    Point away{rho - points_[0].rho, z - points_[0].z};
    double nearest = away.rho * away.rho + away.z * away.z;
    for (std::size_t n = 0; n + 1 < static_cast<std::size_t>(count_); ++n) {
      const Point from{rho - points_[n].rho, z - points_[n].z};
      // The curve is convex, so the nearest point lies on a segment that faces this one.
      if (from.rho * normals_[n].rho + from.z * normals_[n].z < 0.0) continue;
      const Point piece{points_[n + 1].rho - points_[n].rho, points_[n + 1].z - points_[n].z};
      const double t =
          std::clamp((from.rho * piece.rho + from.z * piece.z) * inverse_squared_[n], 0.0, 1.0);
      const Point gap{from.rho - t * piece.rho, from.z - t * piece.z};
      const double squared = gap.rho * gap.rho + gap.z * gap.z;
      if (squared < nearest) {
        nearest = squared;
        away = gap;
      }
    }
    distance = std::sqrt(nearest);
    if (distance > 0.0) normal = {away.rho / distance, away.z / distance};
  }
  const double outward = rho > 0.0 ? normal.rho / rho : 0.0;
  gradient_T = {outward * p_T.x(), outward * p_T.y(), normal.z};
  return distance - rounding_;
}

std::vector<BurSample> Bur::Samples(int count) const {
  Require(count > 0, "samples: " + std::to_string(count) + " are not allowed; give at least 1");
  // The surface's profile in segments from tip to top: a point of the curve, and the normal there.
  struct Station {
    Point core, normal;
    double area;  ///< surface area below the point
  };
  std::vector<Station> stations;
  const auto rho_of = [&](const Point& core, const Point& n) {
    return core.rho + rounding_ * n.rho;
  };
  const auto add = [&](const Point& core_a, const Point& a, const Point& core_b, const Point& b) {
    for (int piece = stations.empty() ? 0 : 1; piece <= kPieces; ++piece) {
      const double t = double(piece) / kPieces;
      Point n{a.rho + t * (b.rho - a.rho), a.z + t * (b.z - a.z)};
      const double length = std::sqrt(n.rho * n.rho + n.z * n.z);
      n = {n.rho / length, n.z / length};
      const Point core{core_a.rho + t * (core_b.rho - core_a.rho),
                       core_a.z + t * (core_b.z - core_a.z)};
      double area = 0.0;
      if (!stations.empty()) {
        const Station& last = stations.back();
        const double along = rho_of(core, n) - rho_of(last.core, last.normal);
        const double up = core.z + rounding_ * n.z - last.core.z - rounding_ * last.normal.z;
        area = last.area + M_PI * (rho_of(core, n) + rho_of(last.core, last.normal)) *
                               std::sqrt(along * along + up * up);
      }
      stations.push_back({core, n, area});
    }
  };
  const Point last =
      is_hollow() ? normals_[static_cast<std::size_t>(count_ - 2)] : Point{0.0, -1.0};
  for (int i = 0; i < (is_hollow() ? count_ - 1 : count_); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const Point before = i == 0 ? last : normals_[n - 1];
    const Point after = i + 1 == count_ ? Point{0.0, 1.0} : normals_[n];
    // Split an arc longer than a quarter circle in two.
    const Point middle = before.z < 0.0 && after.z > 0.0 ? Point{1.0, 0.0} : after;
    add(points_[n], before, points_[n], middle);
    add(points_[n], middle, points_[n], after);
    if (i + 1 < count_) add(points_[n], after, points_[n + 1], after);
  }
  const double all = stations.back().area;
  std::vector<BurSample> samples;
  double c = 1.0, s = 0.0;
  std::size_t at = 1;
  for (int i = 0; i < count; ++i) {
    const double below = all * (i + 0.5) / count;
    while (stations[at].area < below) ++at;
    const Station &a = stations[at - 1], &b = stations[at];
    const double t = (below - a.area) / (b.area - a.area);
    Point n{a.normal.rho + t * (b.normal.rho - a.normal.rho),
            a.normal.z + t * (b.normal.z - a.normal.z)};
    const double length = std::sqrt(n.rho * n.rho + n.z * n.z);
    n = {n.rho / length, n.z / length};
    const double rho = a.core.rho + t * (b.core.rho - a.core.rho) + rounding_ * n.rho;
    const double z = a.core.z + t * (b.core.z - a.core.z) + rounding_ * n.z;
    samples.push_back({{rho * c, rho * s, z}, {n.rho * c, n.rho * s, n.z}, all / count});
    const double turned = c * kGoldenCos - s * kGoldenSin;
    s = c * kGoldenSin + s * kGoldenCos;
    c = turned;
  }
  return samples;
}

}  // namespace palpate
