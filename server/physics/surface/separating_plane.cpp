#include "server/physics/surface/separating_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/physics/limits.h"

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The point of a simplex that is nearest to the origin, and which of the simplex's points it lies
/// between.
struct Nearest {
  Vec3 x;
  int count;
  int of[3];
};

// The origin is not beyond those points that were there before the last one came, a
// (Ericson, Real-Time Collision Detection (2005), 5.1 and 9.5).

Nearest OfSegment(const Vec3* point, int a, int b) {
  const Vec3 ab = point[b] - point[a];
  const double along = -point[a].dot(ab), length2 = ab.squaredNorm();
  if (!(along > 0.0 && length2 > 0.0)) return {point[a], 1, {a}};
  return {point[a] + std::min(1.0, along / length2) * ab, 2, {a, b}};
}

Nearest OfTriangle(const Vec3* point, int a, int b, int c) {
  const Vec3 &at = point[a], ab = point[b] - at, ac = point[c] - at;
  const Vec3 normal = ab.cross(ac);
  const double to_b = -at.dot(ab), to_c = -at.dot(ac);
  const bool past_ac = normal.cross(ac).dot(at) < 0.0, past_ab = ab.cross(normal).dot(at) < 0.0;
  if (past_ac && to_c > 0.0) return OfSegment(point, a, c);
  const double size2 = normal.squaredNorm();
  if (past_ab || past_ac || !(size2 > 0.0)) return OfSegment(point, a, to_b > 0.0 ? b : c);
  return {normal.dot(at) / size2 * normal, 3, {a, b, c}};
}

/// `count` is 0 where the origin is inside.
Nearest OfTetrahedron(const Vec3* point, int a) {
  Nearest best{Vec3::Zero(), 0, {}};
  for (int i = 1; i < 4; ++i) {
    const int b = (a + i) % 4, c = (a + i % 3 + 1) % 4, d = (a + (i + 1) % 3 + 1) % 4;
    const Vec3 normal = (point[b] - point[a]).cross(point[c] - point[a]);
    const double to_d = normal.dot(point[d] - point[a]), to_origin = -normal.dot(point[a]);
    if (to_d * to_origin > 0.0) continue;  // on one side
    const Nearest face = OfTriangle(point, a, b, c);
    if (best.count == 0 || face.x.squaredNorm() < best.x.squaredNorm()) best = face;
  }
  return best;
}

/// The points of the differences whose hull has the point nearest to the origin.
class Simplex {
 public:
  /// Adds a point; gives the nearest one, and keeps what that lies between.
  Vec3 Add(const Vec3& x) {
    const int a = count_;
    point_[a] = x;
    const Nearest nearest = a == 0   ? Nearest{x, 1, {0}}
                            : a == 1 ? OfSegment(point_, a, 0)
                            : a == 2 ? OfTriangle(point_, a, 0, 1)
                                     : OfTetrahedron(point_, a);
    const Vec3 kept[3] = {point_[nearest.of[0]], point_[nearest.of[1]], point_[nearest.of[2]]};
    std::copy(kept, kept + nearest.count, point_);
    count_ = nearest.count;
    return nearest.x;
  }

 private:
  Vec3 point_[4] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int count_ = 0;
};

}  // namespace

bool FindPlane(const PatchPair& pair, const ToolMotion& motion, const Vec3& guess, double least,
               const Kernels& kernels, SeparatingPlane& plane) noexcept {
  const HullTree::Hull tool = pair.tools.HullOf(pair.tool);
  const HullTree::Hull object = pair.objects.HullOf(pair.object);
  Simplex simplex;
  double nearest = kInfinity;
  plane.n = guess;
  for (plane.tries = 1; plane.tries <= limits::mesh::kDirections; ++plane.tries) {
    const Vec3 highest = object.Lowest(-plane.n, kernels);
    const auto difference = [&](const ToolPose& at, double& gap) -> Vec3 {
      const Vec3 d = at.R * tool.Lowest(at.R.transpose() * plane.n, kernels) + at.p - highest;
      gap = plane.n.dot(d) - pair.radius;
      return d;
    };
    Vec3 lowest = difference(motion.to, plane.after);
    if (plane.after >= least) {
      lowest = difference(motion.from, plane.before);
      if (plane.before >= least) return true;
    }
    const Vec3 x = simplex.Add(lowest);
    const double length = x.norm();
    // No direction tells them apart by more than the nearest point's distance; nor does the search
    // go on where rounding keeps it from coming nearer.
    if (!(length > 0.0 && length < nearest && length - pair.radius >= least)) return false;
    nearest = length;
    plane.n = x / length;
  }
  return false;
}

}  // namespace palpate
