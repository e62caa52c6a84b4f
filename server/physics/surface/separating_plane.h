#pragma once

#include <cstdint>
#include <span>

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/hull_tree.h"
#include "server/physics/surface/tool_pose.h"

namespace palpate {

/// A patch of the tool's mesh, in its frame, and one of the objects', in W.
struct PatchPair {
  PatchPair() = default;
  PatchPair(const HullTree& tools, HullTree::Node tool_node, double rounding,
            const HullTree& objects, HullTree::Node object_node)
      : tool(tools.HullOf(tool_node)), object(objects.HullOf(object_node)), radius(rounding) {}

  HullTree::Hull tool, object;
  double radius = 0.0;  ///< that rounds the tool [m]
};

/// A motion of the tool.
struct ToolMotion {
  const ToolPose& from;
  const ToolPose& to;
};

struct SeparatingPlane {
  Vec3 n = Vec3::Zero();             ///< unit, from object to tool, in W
  double before = 0.0, after = 0.0;  ///< how far the tool's hull lies above the object's [m]
  int tries = 0;                     ///< directions that the search has tried
};

/// Pairs that FindPlanes takes at a time.
inline constexpr int kPlanesAtOnce = 8;

/// Looks for planes that keep the hulls of two patches apart by `least` [m] both before a motion
/// and after it, for each of some pairs from the unit direction in its plane on.  Returns a bit for
/// each that it found: where it finds none, mostly there is none.  A plane that is found is true
/// whatever became of the search.
/// Real-time, deterministic: what comes of a pair does not depend on the others.
///
/// By the algorithm of Gilbert, Johnson & Keerthi (IEEE J. Robotics Automat. 4 (1988) 193-203) for
/// the point of object-to-tool differences that is nearest to the origin, with the tool's hull
/// taken in both places; it stops at the first direction that keeps them apart, as van den Bergen
/// does (J. Graphics Tools 4(2) (1999) 7-25).  Several at once, because a search waits for each of
/// its steps, and what they branch on cannot be foretold.
std::uint32_t FindPlanes(std::span<const PatchPair> pairs, const ToolMotion& motion, double least,
                         const Kernels& kernels, SeparatingPlane* planes) noexcept;

/// The same for one pair.
inline bool FindPlane(const PatchPair& pair, const ToolMotion& motion, const Vec3& guess,
                      double least, const Kernels& kernels, SeparatingPlane& plane) noexcept {
  plane.n = guess;
  return FindPlanes({&pair, 1}, motion, least, kernels, &plane) != 0;
}

}  // namespace palpate
