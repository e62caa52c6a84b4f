#pragma once

#include <cstdint>

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

/// Searches for planes that separate the hulls of two patches by `least` [m] before and after a
/// motion, several at a time, in the lanes of a vector.  If a search finds none, there mostly is
/// none; a plane that it finds is always valid.
/// Real-time, deterministic: the result of a search does not depend on the others.
/// By the algorithm of Gilbert, Johnson & Keerthi, up to the first direction that separates
/// (README.md, "Split").
class PlaneSearches {
 public:
  static constexpr int kAtOnce = 8;

  /// Ends all searches, and sets what those to come ask for.  The poses of `motion` must outlive
  /// them.
  void Reset(const ToolMotion& motion, double least);
  /// One bit for each lane in which a search runs.
  std::uint32_t running() const { return running_; }
  bool IsFull() const { return running_ == (1u << kAtOnce) - 1u; }
  /// Begins a search at the unit direction `guess`, in a lane in which none runs.  Returns the
  /// lane.
  int Begin(const PatchPair& pair, const Vec3& guess);
  /// Tries a direction in each search.  Returns one bit for each lane whose search ends.
  std::uint32_t Try(const Kernels& kernels);
  /// Returns whether the search that ended in this lane has found its plane.
  bool Found(int lane) const { return (found_ >> lane & 1u) != 0; }
  /// Its plane, or what it tried last.
  const SeparatingPlane& plane(int lane) const { return planes_[lane]; }

 private:
  const ToolPose *from_ = nullptr, *to_ = nullptr;
  double least_ = 0.0;
  std::uint32_t running_ = 0, found_ = 0;
  PatchPair pairs_[kAtOnce];
  SeparatingPlane planes_[kAtOnce];
  Simplices simplices_;
};

/// Searches for one plane, starting from `guess`.
bool FindPlane(const PatchPair& pair, const ToolMotion& motion, const Vec3& guess, double least,
               const Kernels& kernels, SeparatingPlane& plane) noexcept;

}  // namespace palpate
