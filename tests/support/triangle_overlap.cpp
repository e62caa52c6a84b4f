#include "tests/support/triangle_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "tests/support/exact_orientation.h"

namespace palpate::test {
namespace {

/// Returns whether segments pq and ab meet when projected along `axis`.
bool SegmentsMeet2d(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, int axis) {
  const int pq_a = Orient2d(p, q, a, axis), pq_b = Orient2d(p, q, b, axis);
  const int ab_p = Orient2d(a, b, p, axis), ab_q = Orient2d(a, b, q, axis);
  if (pq_a * pq_b > 0 || ab_p * ab_q > 0) return false;
  // Neither line separates the ends of the other segment, so the segments meet, unless all points
  // are collinear; then the ends decide.
  for (int i = 1; i <= 2; ++i) {
    const int c = (axis + i) % 3;
    if (std::max(p[c], q[c]) < std::min(a[c], b[c])) return false;
    if (std::max(a[c], b[c]) < std::min(p[c], q[c])) return false;
  }
  return true;
}

/// The same in space: the segments must be coplanar, and all three projections must meet.  At least
/// one projection is one-to-one on their plane or line and so exact; the others miss no meeting.
bool SegmentsMeet(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  if (Orient3d(p, q, a, b) != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (!SegmentsMeet2d(p, q, a, b, axis)) return false;
  }
  return true;
}

bool IsDegenerate(const Triangle& t) {
  for (int axis = 0; axis < 3; ++axis) {
    if (Orient2d(t[0], t[1], t[2], axis) != 0) return false;
  }
  return true;
}

/// @param degenerate  whether t is degenerate.
/// @param p_side, q_side  sides of t's plane on which p and q lie.
bool SegmentMeets(const Vec3& p, const Vec3& q, const Triangle& t, bool degenerate, int p_side,
                  int q_side) {
  const auto meets_an_edge = [&] {
    return SegmentsMeet(p, q, t[0], t[1]) || SegmentsMeet(p, q, t[1], t[2]) ||
           SegmentsMeet(p, q, t[2], t[0]);
  };
  if (degenerate) return meets_an_edge();
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) {
    // In the triangle's plane the segment crosses an edge, or lies wholly inside.
    if (meets_an_edge()) return true;
    for (int axis = 0; axis < 3; ++axis) {
      const int turn = Orient2d(t[0], t[1], t[2], axis);
      if (turn == 0) continue;  // this projection makes a line of the plane
      return Orient2d(t[0], t[1], p, axis) == turn && Orient2d(t[1], t[2], p, axis) == turn &&
             Orient2d(t[2], t[0], p, axis) == turn;
    }
    return false;
  }
  // One point of the line is in the plane: tests whether it is on the same side of all edges.
  const int s0 = Orient3d(p, q, t[0], t[1]), s1 = Orient3d(p, q, t[1], t[2]),
            s2 = Orient3d(p, q, t[2], t[0]);
  const bool positive = s0 > 0 || s1 > 0 || s2 > 0, negative = s0 < 0 || s1 < 0 || s2 < 0;
  return !(positive && negative);
}

/// Returns whether an edge of a meets b.
struct Sides {
  bool degenerate;
  int of[3];
  Sides(const Triangle& of_plane, const Triangle& corners) : degenerate(IsDegenerate(of_plane)) {
    for (std::size_t i = 0; i < 3; ++i) {
      of[i] = degenerate ? 0 : Orient3d(of_plane[0], of_plane[1], of_plane[2], corners[i]);
    }
  }
  bool apart() const {
    return (of[0] > 0 && of[1] > 0 && of[2] > 0) || (of[0] < 0 && of[1] < 0 && of[2] < 0);
  }
};

bool AnEdgeMeets(const Triangle& a, const Triangle& b, const Sides& sides) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (SegmentMeets(a[i], a[j], b, sides.degenerate, sides.of[i], sides.of[j])) return true;
  }
  return false;
}

/// Nearest points of segments pq and ab (Ericson, Real-Time Collision Detection, 5.1.9).
Nearest NearestOfSegments(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  const Vec3 d1 = q - p, d2 = b - a, r = p - a;
  const double A = d1.squaredNorm(), E = d2.squaredNorm(), f = d2.dot(r);
  double s = 0.0, t = 0.0;
  const auto share = [](double x) { return std::clamp(x, 0.0, 1.0); };
  if (A <= 0.0 && E <= 0.0) {
  } else if (A <= 0.0) {
    t = share(f / E);
  } else {
    const double c = d1.dot(r);
    if (E <= 0.0) {
      s = share(-c / A);
    } else {
      const double B = d1.dot(d2), denominator = A * E - B * B;
      if (denominator > 0.0) s = share((B * f - c * E) / denominator);
      t = (B * s + f) / E;
      if (t < 0.0) {
        t = 0.0;
        s = share(-c / A);
      } else if (t > 1.0) {
        t = 1.0;
        s = share((B - c) / A);
      }
    }
  }
  const Vec3 on_a = p + s * d1, on_b = a + t * d2;
  return {(on_a - on_b).norm(), on_a, on_b};
}

}  // namespace

bool Meet(const Triangle& a, const Triangle& b) {
  const Sides a_of_b(b, a);
  if (a_of_b.apart()) return false;
  const Sides b_of_a(a, b);
  if (b_of_a.apart()) return false;
  // The intersection of convex bodies is convex; one of its corners lies on an edge of a body.
  return AnEdgeMeets(a, b, a_of_b) || AnEdgeMeets(b, a, b_of_a);
}

Separation ShortestSeparation(const Triangle& a, const Triangle& b) {
  Separation best{std::numeric_limits<double>::infinity()};
  const auto edge = [](const Triangle& t, std::size_t i) { return Vec3(t[(i + 1) % 3] - t[i]); };
  const auto consider = [&](const Vec3& axis, double scale) {
    const double length = axis.norm();
    // Parallel edges, no area: no axis.  Rounding leaves some 1e-16 of the scale.
    if (!(length > 1e-12 * scale)) return;
    const Vec3 n = axis / length;
    // Relative to a's first corner: small numbers have small rounding errors.
    double a_low = 0.0, a_high = 0.0, b_low = INFINITY, b_high = -INFINITY;
    for (const Vec3& p : a) {
      a_low = std::min(a_low, n.dot(p - a[0]));
      a_high = std::max(a_high, n.dot(p - a[0]));
    }
    for (const Vec3& p : b) {
      b_low = std::min(b_low, n.dot(p - a[0]));
      b_high = std::max(b_high, n.dot(p - a[0]));
    }
    const double up = a_high - b_low, down = b_high - a_low;
    const double depth = std::max(0.0, std::min(up, down));
    if (depth < best.depth) best = {depth, up <= down ? n : Vec3(-n)};
  };
  const auto scale_of = [](const Vec3& u, const Vec3& v) { return u.norm() * v.norm(); };
  for (const Triangle* t : {&a, &b}) {
    consider(edge(*t, 0).cross(edge(*t, 1)), scale_of(edge(*t, 0), edge(*t, 1)));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      consider(edge(a, i).cross(edge(b, j)), scale_of(edge(a, i), edge(b, j)));
    }
  }
  if (!std::isfinite(best.depth)) return {};
  return best;
}

Vec3 NearestPoint(const Triangle& t, const Vec3& p) {
  // Inside the face's prism the foot of the perpendicular, else the nearest point of an edge.
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0) {
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      inside &= normal.cross(t[(i + 1) % 3] - t[i]).dot(p - t[i]) >= 0.0;
    }
    if (inside) return p - normal * (normal.dot(p - t[0]) / area2);
  }
  Vec3 best = t[0];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 along = t[(i + 1) % 3] - t[i];
    const double length2 = along.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp(along.dot(p - t[i]) / length2, 0.0, 1.0) : 0.0;
    const Vec3 foot = t[i] + share * along;
    if ((p - foot).squaredNorm() < least) {
      least = (p - foot).squaredNorm();
      best = foot;
    }
  }
  return best;
}

Nearest NearestPoints(const Triangle& a, const Triangle& b) {
  Nearest best{std::numeric_limits<double>::infinity(), a[0], b[0]};
  const auto consider = [&](const Vec3& on_a, const Vec3& on_b) {
    const double distance = (on_a - on_b).norm();
    if (distance < best.distance) best = {distance, on_a, on_b};
  };
  for (const Vec3& p : a) consider(p, NearestPoint(b, p));
  for (const Vec3& p : b) consider(NearestPoint(a, p), p);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const Nearest edges = NearestOfSegments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]);
      if (edges.distance < best.distance) best = edges;
    }
  }
  return best;
}

}  // namespace palpate::test
