#pragma once

#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// How balls lie relative to the mesh that they are to represent.
struct TreeAlignment {
  Vec3 shift = Vec3::Zero();  ///< to be added to each centre [m]
  bool fitted = false;        ///< false: `shift` is exactly one of the likely ones
  /// Over the surface, the rms deviation of the distance to the union of the balls (negative inside
  /// it) from its mean, and that mean [m].
  double residual = 0.0, mean = 0.0;
  double uncovered_share = 0.0;  ///< share of the surface that lies in no ball
  /// Distance of neighbouring balls, if all were spread over the surface [m].
  double spacing = 0.0;
  /// For people: why the balls are probably of another mesh, with a remedy; empty if they fit.
  std::string misfit;
};

/// Finds the translation that a .sph file has lost (sph_file.h): the one with which the distance
/// from the surface to the union of the balls varies least.  Starts from three shifts: none, the
/// centre of the mesh's box, about which the toolkit works, and the one that makes the centres of
/// both boxes equal.  Refines each by damped Gauss-Newton steps on the distances at some thousand
/// points of the surface, for the shift and the mean distance.  One of the boxes must contain the
/// other, to within 2 % of the diagonal: otherwise badly fitting balls would be moved far away,
/// where all points are equally far from them.
///
/// No shift and the box's centre are probably meant exactly.  So one of them is taken if its
/// residual is at most 2 % above the least, or at most twice the least if the balls then contain
/// the surface.  Otherwise the error of the shift is some tenth of the residual: with 512 balls
/// less than a thousandth of the diagonal, with thin walls up to a hundredth, and with an octree's
/// balls, which stick out unevenly, up to 4 %.  So pass the finest level, whatever level is wanted.
///
/// Set-up only.  Deterministic.
/// @param balls  at least one, finite, each with a radius above 0; frame B but for the shift [m].
/// @param move   false: do not shift, only measure how the balls fit.
/// Throws Error if the balls are so much larger or smaller than the mesh that the unit must be
/// wrong, or if no shift brings them to the mesh.
TreeAlignment AlignBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                         bool move = true);

}  // namespace palpate
