#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "common/math/rotation.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/hull_tree.h"

namespace palpate {

/// The pose X_BA of a body A in the frame of the bodies B that it meets: its reference point, and
/// its orientation.
struct RelativePose : Placement {
  Quat q;
  RelativePose(const Vec3& position, const Quat& orientation)
      : Placement{position, orientation.toRotationMatrix()}, q(orientation) {}
  /// Returns the pose after the step [v; phi].
  RelativePose Moved(const Vec3& v, const Vec3& phi) const {
    return {p + v, (RotationExp(phi) * q).normalized()};
  }
};

/// Where A is before and after a motion, in the frame S of a body of B.
struct ShapeMotion {
  Placement from, to;
};

/// A patch of A's mesh and one of B's, in their frames.
struct PatchPair {
  HullTree::Hull a, b;
  double radius = 0.0;  ///< rounding of A [m]
};

struct SeparatingPlane {
  Vec3 n = Vec3::Zero();             ///< unit, from B to A, in S
  double before = 0.0, after = 0.0;  ///< how far A's hull lies above B's [m]
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

  /// Ends all searches, and sets the gap that those to come ask for.
  void Reset(double least);
  /// One bit for each lane in which a search runs.
  std::uint32_t running() const { return running_; }
  bool IsFull() const { return running_ == (1u << kAtOnce) - 1u; }
  /// Begins a search at the unit direction `guess`, in a lane in which none runs.  Returns the
  /// lane.  `motion` must outlive the search.
  int Begin(const PatchPair& pair, const ShapeMotion& motion, const Vec3& guess);
  /// Tries a direction in each search.  Returns one bit for each lane whose search ends.
  std::uint32_t Try(const Kernels& kernels);
  /// Returns whether the search that ended in this lane has found its plane.
  bool Found(int lane) const { return (found_ >> lane & 1u) != 0; }
  /// Its plane, or what it tried last.
  const SeparatingPlane& plane(int lane) const { return planes_[lane]; }

 private:
  double least_ = 0.0;
  std::uint32_t running_ = 0, found_ = 0;
  PatchPair pairs_[kAtOnce];
  const ShapeMotion* motions_[kAtOnce];
  SeparatingPlane planes_[kAtOnce];
  Simplices simplices_;
};

/// Searches for one plane, starting from `guess`.
bool FindPlane(const PatchPair& pair, const ShapeMotion& motion, const Vec3& guess, double least,
               const Kernels& kernels, SeparatingPlane& plane) noexcept;

}  // namespace palpate
