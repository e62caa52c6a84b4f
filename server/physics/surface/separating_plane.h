#pragma once

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/hull_tree.h"
#include "server/physics/surface/tool_pose.h"

namespace palpate {

/// A patch of the tool's mesh, in its frame, and one of the objects', in W.
struct PatchPair {
  const HullTree& tools;
  HullTree::Node tool;
  double radius;  ///< that rounds the tool [m]
  const HullTree& objects;
  HullTree::Node object;
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

/// Looks for a plane that keeps the hulls of two patches apart by `least` [m] both before a motion
/// and after it, from the unit direction `guess` on.  False where it finds none: mostly since there
/// is none.  A plane that is found is true whatever became of the search.
/// Real-time, deterministic.
///
/// By the algorithm of Gilbert, Johnson & Keerthi (IEEE J. Robotics Automat. 4 (1988) 193-203) for
/// the point of object-to-tool differences that is nearest to the origin, with the tool's hull
/// taken in both places; it stops at the first direction that keeps them apart, as van den Bergen
/// does (J. Graphics Tools 4(2) (1999) 7-25).
bool FindPlane(const PatchPair& pair, const ToolMotion& motion, const Vec3& guess, double least,
               const Kernels& kernels, SeparatingPlane& plane) noexcept;

}  // namespace palpate
