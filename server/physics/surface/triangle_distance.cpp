#include "server/physics/surface/triangle_distance.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

Feature At(double s, int edge) {
  if (s <= 0.0) return {Feature::kVertex, static_cast<std::uint8_t>(edge)};
  if (s >= 1.0) return {Feature::kVertex, static_cast<std::uint8_t>((edge + 1) % 3)};
  return {Feature::kEdge, static_cast<std::uint8_t>(edge)};
}

double Clamp(double x) {
  return x < 0.0 ? 0.0 : (x > 1.0 ? 1.0 : x);
}

/// Parameters of the nearest points of p + s u and q + t w, r = p - q.
void NearestOfSegments(const Vec3& u, const Vec3& w, const Vec3& r, double uu, double ww, double& s,
                       double& t) {
  const double uw = u.dot(w), ur = u.dot(r), wr = w.dot(r);
  const double across = uu * ww - uw * uw;
  s = across > 0.0 ? Clamp((uw * wr - ur * ww) / across) : 0.0;
  if (!(ww > 0.0) && uu > 0.0) s = Clamp(-ur / uu);  // the second is a point
  t = ww > 0.0 ? (uw * s + wr) / ww : 0.0;
  if (t < 0.0) {
    t = 0.0;
    s = uu > 0.0 ? Clamp(-ur / uu) : 0.0;
  } else if (t > 1.0) {
    t = 1.0;
    s = uu > 0.0 ? Clamp((uw - ur) / uu) : 0.0;
  }
}

}  // namespace

NearestPoints NearestOfTriangles(const Vec3 a[3], const Vec3 b[3]) noexcept {
  NearestPoints best;
  best.squared = std::numeric_limits<double>::infinity();
  const Vec3 ea[3] = {a[1] - a[0], a[2] - a[1], a[0] - a[2]};
  const Vec3 eb[3] = {b[1] - b[0], b[2] - b[1], b[0] - b[2]};
  const double aa[3] = {ea[0].squaredNorm(), ea[1].squaredNorm(), ea[2].squaredNorm()};
  const double bb[3] = {eb[0].squaredNorm(), eb[1].squaredNorm(), eb[2].squaredNorm()};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3 r = a[i] - b[j];
      double s, t;
      NearestOfSegments(ea[i], eb[j], r, aa[i], bb[j], s, t);
      const Vec3 away = r + s * ea[i] - t * eb[j];
      const double squared = away.squaredNorm();
      if (squared < best.squared) {
        best.squared = squared;
        best.p = a[i] + s * ea[i];
        best.q = b[j] + t * eb[j];
        best.of_p = At(s, i);
        best.of_q = At(t, j);
        // A slab across the way between keeps the third corners out too: nothing is nearer
        // (Larsen, Gottschalk, Lin & Manocha, UNC TR99-018 (1999)).
        const bool apart =
            away.dot(a[(i + 2) % 3] - best.p) >= 0.0 && away.dot(b[(j + 2) % 3] - best.q) <= 0.0;
        if (apart && squared > 0.0) return best;
      }
    }
  }
  // A corner above the inside of the other's face.
  const auto faces = [&best](const Vec3* face, const Vec3* edge, const Vec3* corner, bool of_a) {
    const Vec3 n = edge[0].cross(edge[1]);
    const double nn = n.squaredNorm();
    if (!(nn > 0.0)) return;
    for (int i = 0; i < 3; ++i) {
      const double height = n.dot(corner[i] - face[0]);
      if (!(height * height < best.squared * nn)) continue;
      bool inside = true;
      for (int k = 0; k < 3 && inside; ++k) {
        inside = n.dot(edge[k].cross(corner[i] - face[k])) > 0.0;
      }
      if (!inside) continue;
      best.squared = height * height / nn;
      const Vec3 foot = corner[i] - height / nn * n;
      const Feature vertex{Feature::kVertex, static_cast<std::uint8_t>(i)}, on{Feature::kFace, 0};
      best.p = of_a ? corner[i] : foot;
      best.q = of_a ? foot : corner[i];
      best.of_p = of_a ? vertex : on;
      best.of_q = of_a ? on : vertex;
    }
  };
  faces(b, eb, a, true);
  faces(a, ea, b, false);
  return best;
}

}  // namespace palpate
