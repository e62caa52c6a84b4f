#pragma once

#include <cstdint>
#include <span>

#include "common/math/pose.h"
#include "common/math/rotation.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/hull_tree.h"

namespace palpate {

/// The pose of the graphic tool: its reference point in W, and its orientation.
struct ToolPose {
  Vec3 p;
  Quat q;
  Mat3 R;
  ToolPose(const Vec3& position, const Quat& orientation)
      : p(position), q(orientation), R(orientation.toRotationMatrix()) {}
  /// Returns the pose after the step [v; phi].
  ToolPose Moved(const Vec3& v, const Vec3& phi) const {
    return {p + v, (RotationExp(phi) * q).normalized()};
  }
};

/// A patch of the tool's mesh, in its frame, and one of an object's, in W.
struct PatchPair {
  PatchPair() = default;
  PatchPair(const HullTree& tools, HullTree::Node tool_node, double rounding,
            const HullTree& objects, HullTree::Node object_node)
      : tool(tools.HullOf(tool_node)), object(objects.HullOf(object_node)), radius(rounding) {}

  HullTree::Hull tool, object;
  double radius = 0.0;  ///< rounding of the tool [m]
};

/// A motion of the tool between two poses.
struct ToolMotion {
  const ToolPose& from;
  const ToolPose& to;
};

struct SeparatingPlane {
  Vec3 n = Vec3::Zero();             ///< unit, from object to tool, in W
  double before = 0.0, after = 0.0;  ///< how far the tool's hull lies above the object's [m]
  int tries = 0;                     ///< number of directions that the search has tried
};

/// Number of pairs that FindPlanes takes at a time.
inline constexpr int kPlanesAtOnce = 8;

/// For each pair, searches for a plane that separates the hulls of both patches by `least` [m]
/// before and after a motion, starting from the unit direction in planes[i].n.  Returns one bit for
/// each pair for which it found a plane.  If it finds none, there mostly is none; a plane that it
/// finds is always valid.
/// Real-time, deterministic: the result for a pair does not depend on the other pairs.
/// By the algorithm of Gilbert, Johnson & Keerthi, up to the first direction that separates
/// (README.md, "Split").
std::uint32_t FindPlanes(std::span<const PatchPair> pairs, const ToolMotion& motion, double least,
                         const Kernels& kernels, SeparatingPlane* planes) noexcept;

/// FindPlanes for one pair, starting from `guess`.
inline bool FindPlane(const PatchPair& pair, const ToolMotion& motion, const Vec3& guess,
                      double least, const Kernels& kernels, SeparatingPlane& plane) noexcept {
  plane.n = guess;
  return FindPlanes({&pair, 1}, motion, least, kernels, &plane) != 0;
}

}  // namespace palpate
