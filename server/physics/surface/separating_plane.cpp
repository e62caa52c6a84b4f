#include "server/physics/surface/separating_plane.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "server/physics/limits.h"

namespace palpate {

std::uint32_t FindPlanes(std::span<const PatchPair> pairs, const ToolMotion& motion, double least,
                         const Kernels& kernels, SeparatingPlane* planes) noexcept {
  Simplices simplices;
  std::fill_n(simplices.nearest, kPlanesAtOnce, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < pairs.size(); ++i) simplices.radius[i] = pairs[i].radius;
  std::uint32_t found = 0, searches = (1u << pairs.size()) - 1u;
  for (int tries = 1; searches != 0; ++tries) {
    for (std::uint32_t left = searches; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      const PatchPair& pair = pairs[static_cast<std::size_t>(i)];
      SeparatingPlane& plane = planes[i];
      if (tries > 1) plane.n = {simplices.n[0][i], simplices.n[1][i], simplices.n[2][i]};
      plane.tries = tries;
      if (tries > limits::mesh::kDirections) continue;
      const Vec3 highest = pair.object.Lowest(-plane.n, kernels);
      const auto difference = [&](const ToolPose& at, double& gap) -> Vec3 {
        const Vec3 d =
            at.R * pair.tool.Lowest(at.R.transpose() * plane.n, kernels) + at.p - highest;
        gap = plane.n.dot(d) - pair.radius;
        return d;
      };
      Vec3 lowest = difference(motion.to, plane.after);
      if (plane.after >= least) {
        lowest = difference(motion.from, plane.before);
        if (plane.before >= least) found |= 1u << i;
      }
      for (int c = 0; c < 3; ++c) simplices.added[c][i] = lowest[c];
    }
    if (tries > limits::mesh::kDirections) break;
    searches &= ~found;
    if (searches != 0) searches = kernels.advance_simplices(simplices, searches, least);
  }
  return found;
}

}  // namespace palpate
