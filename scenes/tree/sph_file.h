#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/sphere_tree.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// A sphere tree in the format of the Sphere-Tree Construction Toolkit (Bradshaw & O'Sullivan,
/// ACM TOG 23 (2004) 1-26; isg.cs.tcd.ie/spheretree), a .sph file.  The format, as inferred from
/// the sources of the toolkit:
/// - the first line is "levels degree", the root being the first level;
/// - then comes a line "x y z r importance" for each node, breadth first: a row for each level, and
///   in it `degree` slots for the children of each node of the row above, used or not.  Unused
///   slots have a radius of 0 or less.  Some versions omit the importance, or write a second ball
///   after it, which is ignored;
/// - what follows is not part of the tree: the toolkit appends its options and its measurements.
/// Numbers have six decimals, in the unit of the source mesh.  The toolkit centres that mesh on the
/// origin and writes the tree there: align it (tree_alignment.h).
struct SphTree {
  struct Node {
    Sphere ball;              ///< [m]
    double importance = 1.0;  ///< the toolkit's "occupancy": kept, but not used
    bool used() const { return ball.radius > 0.0; }
  };
  int levels = 0;  ///< at least 1
  int degree = 0;  ///< at least 1
  std::vector<Node> nodes;
};

/// Limits of a tree's depth and of its file's size: a million leaves of degree 8 fit.
inline constexpr int kMaxSphLevels = 24;
inline constexpr std::size_t kLargestSphFile = std::size_t{128} << 20;

/// Parses a .sph file.  Throws Error "file:line: what; remedy" if it is damaged, truncated, of
/// another format, or too large.  Uses at most six times the text's memory.
/// @param metres_per_unit  what a number in the file means.
SphTree ParseSph(std::string_view text, const std::string& file, double metres_per_unit);
/// Returns the text of such a file.  Throws Error if it is too large.
std::string ReadSphText(const std::string& file);
SphTree ReadSph(const std::string& file, double metres_per_unit);

/// Returns the text of a .sph file, with six decimals: in millimetres, that is a nanometre.
std::string ToSph(const SphTree& tree, double metres_per_unit);

/// Converts one of Palpate's trees.  The root is the ball round all leaves, and the degree is 8, so
/// the result has one level more than the tree.  Balls of inner levels bound what is below them.
/// @param levels  number of levels below the root; 0: all.
/// Throws Error if the nodes have too many slots.
SphTree SphOf(const SphereTree& tree, int levels = 0);

/// Returns the balls that represent the solid at a level: those of its row, and those of coarser
/// rows without children, where the toolkit found nothing to refine.
/// @param level  from 1, the root, to tree.levels.
std::vector<Sphere> BallsOfLevel(const SphTree& tree, int level);

}  // namespace palpate
