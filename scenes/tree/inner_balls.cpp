#include "scenes/tree/inner_balls.h"

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"

namespace palpate {
namespace {

constexpr double kLeast = 1e-6;  // of the spacing: a smaller ball does not count
constexpr double kFilled = 0.5;  // of the spacing: smaller voids count as filled

/// Returns the distance of the surface from the ball, half the spacing away from where
/// it should touch.
double Gap(const Sphere& ball, const SurfaceSample& s, double spacing) {
  const double distance = (s.point - ball.centre).norm();
  return std::sqrt(distance * distance + 0.25 * spacing * spacing) - ball.radius;
}

}  // namespace

InnerBalls::InnerBalls(const MeshReport& report, const MeshQuery& query, double spacing,
                       double largest_touching)
    : report_(report), query_(query), spacing_(spacing) {
  const Vec3 extent = report.box_max - report.box_min;
  largest_ = 0.5 * extent.minCoeff();
  largest_touching_ = std::min(largest_, largest_touching * spacing);
}

Sphere InnerBalls::Shrink(const Vec3& point, const Vec3& outward, double depth,
                          double largest) const {
  // Takes the ball of radius r - depth about point - r * outward.  It begins as large as possible,
  // and shrinks until the furthest surface point inside it touches it, until no point is inside.
  double r = largest;
  Vec3 centre = point - r * outward;
  for (int i = 0; i < 50; ++i) {
    const MeshQuery::Hit hit = query_.Nearest(centre, (r - depth) * (1.0 - 1e-9));
    if (hit.triangle == MeshQuery::kNone) break;
    const Vec3 d = hit.point - point;
    const double below = -outward.dot(d) - depth;
    if (!(below > 0.0)) break;
    const double smaller = (d.squaredNorm() - depth * depth) / (2.0 * below);
    if (!(smaller < r)) break;
    r = smaller;
    centre = point - r * outward;
  }
  const double within = query_.Nearest(centre).distance;
  if (report_.closed()) return {centre, within};
  // Through a hole the ball could leave the solid, so keep it in the mesh's box.
  const double to_box = (centre - report_.box_min).cwiseMin(report_.box_max - centre).minCoeff();
  return {centre, std::clamp(to_box, 0.0, within)};
}

Sphere InnerBalls::Tangent(const SurfaceSample& s) const {
  // Next to an edge between two facets of a smooth surface, a ball that touches its facet exactly
  // is tiny.  If it lies a little deeper or leans with the smooth normal, it may be far larger.
  Sphere best = Shrink(s.point, s.outward, 0.0, largest_touching_);
  double best_gap = Gap(best, s, spacing_);
  Vec3 smooth = query_.SmoothNormal(s.triangle, s.point);
  if (smooth.dot(s.outward) < 0.0) smooth = -smooth;
  for (const Vec3& outward : {s.outward, smooth}) {
    for (const double depth : {0.003, 0.01, 0.03}) {
      const Sphere ball = Shrink(s.point, outward, depth * spacing_, largest_touching_);
      const double gap = Gap(ball, s, spacing_);
      if (gap < best_gap) {
        best_gap = gap;
        best = ball;
      }
    }
  }
  // Where the surface folds over itself, a facet faces the wrong way, and its ball would lie
  // outside.  Between two faces back to back the ball has no radius except for rounding.
  if (best.radius < kLeast * spacing_ || !query_.Inside(best.centre)) return {s.point, 0.0};
  return best;
}

Sphere InnerBalls::Within(const SurfaceSample& s) const {
  const Sphere ball = Shrink(s.point, s.outward, 0.0, largest_touching_);
  const bool fits = ball.radius >= kLeast * spacing_ && query_.Inside(ball.centre);
  return fits ? ball : Sphere{s.point, 0.0};
}

std::vector<Sphere> InnerBalls::Fill(const std::vector<Sphere>& balls, std::size_t count,
                                     double places) const {
  struct Point {
    Vec3 at;
    double bare;  ///< distance to the nearest ball; to the surface if there is no ball yet
  };
  std::vector<Point> points;
  const SphereQuery covered(balls);
  const Vec3 extent = report_.box_max - report_.box_min;
  const double step = Pow(extent.cwiseMax(0.01 * extent.maxCoeff()).prod() / places, 1.0 / 3.0);
  for (double x = 0.5 * step; x < extent.x(); x += step) {
    for (double y = 0.5 * step; y < extent.y(); y += step) {
      for (double z = 0.5 * step; z < extent.z(); z += step) {
        const Vec3 p = report_.box_min + Vec3(x, y, z);
        if (!query_.Inside(p)) continue;
        points.push_back(
            {p, balls.empty() ? query_.Nearest(p).distance : covered.Nearest(p).distance});
      }
    }
  }
  std::vector<Sphere> added;
  while (added.size() < count && !points.empty()) {
    const Point worst =
        *std::max_element(points.begin(), points.end(),
                          [](const Point& a, const Point& b) { return a.bare < b.bare; });
    if (!balls.empty() && worst.bare < kFilled * spacing_) break;
    const MeshQuery::Hit hit = query_.Nearest(worst.at);
    Sphere ball{worst.at, hit.distance};
    if (hit.distance > 0.0) {
      const Sphere grown = Shrink(hit.point, (hit.point - worst.at) / hit.distance, 0.0, largest_);
      if (grown.radius > ball.radius) ball = grown;
    }
    if (!(ball.radius > 0.0)) break;
    added.push_back(ball);
    for (Point& p : points) p.bare = std::min(p.bare, (p.at - ball.centre).norm() - ball.radius);
    std::erase_if(points, [](const Point& p) { return p.bare <= 0.0; });
  }
  return added;
}

}  // namespace palpate
