#include "server/physics/surface/triangle_distance.h"

namespace palpate {
namespace {

Feature At(double s, int edge) {
  if (s <= 0.0) return {Feature::kVertex, static_cast<std::uint8_t>(edge)};
  if (s >= 1.0) return {Feature::kVertex, static_cast<std::uint8_t>((edge + 1) % 3)};
  return {Feature::kEdge, static_cast<std::uint8_t>(edge)};
}

}  // namespace

NearestPoints NearestOfTriangles(const Vec3 a[3], const Vec3 b[3],
                                 const Kernels& kernels) noexcept {
  const EdgePair edges = kernels.nearest_edges(a->data(), b->data());
  const Vec3 ea[3] = {a[1] - a[0], a[2] - a[1], a[0] - a[2]};
  const Vec3 eb[3] = {b[1] - b[0], b[2] - b[1], b[0] - b[2]};
  const int i = edges.place / 3, j = edges.place % 3;
  NearestPoints best{a[i] + edges.s * ea[i], b[j] + edges.t * eb[j], At(edges.s, i), At(edges.t, j),
                     edges.squared};
  if (edges.apart) return best;
  // A corner above the inside of the other's face.
  const auto faces = [&best](const Vec3* face, const Vec3* edge, const Vec3* corner, bool of_a) {
    const Vec3 n = edge[0].cross(edge[1]);
    const double nn = n.squaredNorm();
    if (!(nn > 0.0)) return;
    for (int c = 0; c < 3; ++c) {
      const double height = n.dot(corner[c] - face[0]);
      if (!(height * height < best.squared * nn)) continue;
      bool inside = true;
      for (int k = 0; k < 3 && inside; ++k) {
        inside = n.dot(edge[k].cross(corner[c] - face[k])) > 0.0;
      }
      if (!inside) continue;
      best.squared = height * height / nn;
      const Vec3 foot = corner[c] - height / nn * n;
      const Feature vertex{Feature::kVertex, static_cast<std::uint8_t>(c)}, on{Feature::kFace, 0};
      best.p = of_a ? corner[c] : foot;
      best.q = of_a ? foot : corner[c];
      best.of_p = of_a ? vertex : on;
      best.of_q = of_a ? on : vertex;
    }
  };
  faces(b, eb, a, true);
  faces(a, ea, b, false);
  return best;
}

}  // namespace palpate
