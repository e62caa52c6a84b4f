#pragma once

#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// Where balls lie against the mesh that they are to stand for.
struct TreeAlignment {
  Vec3 shift = Vec3::Zero();  ///< to be added to each centre [m]
  bool fitted = false;        ///< false: `shift` is one of the likely ones, exactly
  /// Over the surface: rms of the distance to the union of the balls, which is negative inside it,
  /// about its mean [m], and that mean [m].
  double residual = 0.0, mean = 0.0;
  double uncovered_share = 0.0;  ///< of the surface: lies in no ball
  /// Distance of neighbouring balls, were all of them spread over the surface [m].
  double spacing = 0.0;
  /// For people: why the balls hardly are those of this mesh, with a remedy; empty where they may
  /// be.
  std::string misfit;
};

/// Finds the translation that a .sph file has lost (sph_file.h): the one with which the distance
/// from the surface to the union of the balls varies least.  Starts from no shift, from the centre
/// of the mesh's box, about which the toolkit works, and from where both boxes have the same
/// centre; refines by damped Gauss-Newton steps on the distances at some thousand points of the
/// surface, for the shift and the mean distance.  One of the boxes has to hold the other, but for
/// 2 % of the diagonal: else balls that fit badly would be moved far away, where all points are as
/// far from them.
/// No shift and the box's centre are likely to be meant exactly, so that one of them is taken where
/// its residual is at most 2 % above the least, or twice it where the balls then hold the surface.
/// Elsewhere the shift is off by some tenth of the residual: with 512 balls by less than a
/// thousandth of the diagonal, with thin walls by up to a hundredth, and with an octree's balls,
/// which stick out unevenly, by up to 4 %.  So give the finest level, whatever level is wanted.
/// Set-up only.  Deterministic.
/// @param balls  at least one, finite, each with a radius above 0; frame B but for the shift [m].
/// @param move   false: no shift; only says how the balls fit.
/// Throws Error where the balls are so much larger or smaller than the mesh that the unit must be
/// another one, or where no shift brings them to the mesh at all.
TreeAlignment AlignBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                         bool move = true);

}  // namespace palpate
