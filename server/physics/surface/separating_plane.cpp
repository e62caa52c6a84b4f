#include "server/physics/surface/separating_plane.h"

#include <bit>
#include <limits>
#include <utility>

#include "server/physics/limits.h"

namespace palpate {

void PlaneSearches::Reset(double least) {
  least_ = least;
  running_ = 0;
}

int PlaneSearches::Begin(const PatchPair& pair, const ShapeMotion& motion, const Vec3& guess) {
  const int lane = std::countr_one(running_);
  running_ |= 1u << lane;
  pairs_[lane] = pair;
  motions_[lane] = &motion;
  planes_[lane].n = guess;
  planes_[lane].tries = 0;
  for (std::uint32_t& with : simplices_.with) with &= ~(1u << lane);
  simplices_.nearest[lane] = std::numeric_limits<double>::infinity();
  simplices_.radius[lane] = pair.radius;
  return lane;
}

[[gnu::flatten]] std::uint32_t PlaneSearches::Try(const Kernels& kernels) {
  found_ = 0;
  std::uint32_t goes_on = 0;
  for (std::uint32_t left = running_; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const PatchPair& pair = pairs_[i];
    SeparatingPlane& plane = planes_[i];
    if (plane.tries > 0) {
      plane.n = {simplices_.n[0][i], simplices_.n[1][i], simplices_.n[2][i]};
    }
    ++plane.tries;
    const Vec3 highest = pair.b.Lowest(-plane.n, kernels);
    const auto difference = [&](const Placement& at, double& gap) -> Vec3 {
      const Vec3 d = at.R * pair.a.Lowest(at.R.transpose() * plane.n, kernels) + at.p - highest;
      gap = plane.n.dot(d) - pair.radius;
      return d;
    };
    Vec3 lowest = difference(motions_[i]->to, plane.after);
    if (plane.after >= least_) {
      lowest = difference(motions_[i]->from, plane.before);
      if (plane.before >= least_) found_ |= 1u << i;
    }
    for (int c = 0; c < 3; ++c) simplices_.added[c][i] = lowest[c];
    if (plane.tries < limits::mesh::kDirections) goes_on |= 1u << i;
  }
  goes_on &= ~found_;
  if (goes_on != 0) goes_on = kernels.advance_simplices(simplices_, goes_on, least_);
  return std::exchange(running_, goes_on) & ~goes_on;
}

bool FindPlane(const PatchPair& pair, const ShapeMotion& motion, const Vec3& guess, double least,
               const Kernels& kernels, SeparatingPlane& plane) noexcept {
  PlaneSearches searches;
  searches.Reset(least);
  const int lane = searches.Begin(pair, motion, guess);
  while (searches.Try(kernels) == 0) {
  }
  plane = searches.plane(lane);
  return searches.Found(lane);
}

}  // namespace palpate
