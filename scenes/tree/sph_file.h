#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/sphere_tree.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// A sphere tree as the Sphere-Tree Construction Toolkit (Bradshaw & O'Sullivan, ACM TOG 23 (2004)
/// 1-26; isg.cs.tcd.ie/spheretree) writes it into a .sph file.  Its format, as read from what the
/// toolkit does:
/// - the first line is "levels degree", the root being the first level;
/// - then each node has a line "x y z r importance", breadth first: a row for each level, and in it
///   `degree` slots for the children of each node of the row above, whether they are used or not.
///   Unused slots have a radius of 0 or less.  Some versions leave the importance out, or have a
///   second ball after it, which is not read;
/// - whatever follows is not of the tree: the toolkit adds its options and its own measurements.
/// Numbers have six decimals, in the unit of the mesh that the tree was made of.  The toolkit moves
/// that mesh about the origin and writes the tree there: align it (tree_alignment.h).
struct SphTree {
  struct Node {
    Sphere ball;              ///< [m]
    double importance = 1.0;  ///< the toolkit's "occupancy"; kept, and of no other use here
    bool used() const { return ball.radius > 0.0; }
  };
  int levels = 0;  ///< at least 1
  int degree = 0;  ///< at least 1
  std::vector<Node> nodes;
};

/// A tree is no deeper than this, and its file no larger: a million leaves of degree 8 fit.
inline constexpr int kMaxSphLevels = 24;
inline constexpr std::size_t kLargestSphFile = std::size_t{128} << 20;

/// Throws Error "file:line: what; remedy" where the file is damaged, cut short, not such a file, or
/// too large; takes no more memory than six times the text's.
/// @param metres_per_unit  what a number in the file means.
SphTree ParseSph(std::string_view text, const std::string& file, double metres_per_unit);
/// The text of such a file, which is refused where it is too large.
std::string ReadSphText(const std::string& file);
SphTree ReadSph(const std::string& file, double metres_per_unit);

/// The text of a .sph file: six decimals of the unit, so in millimetres to a nanometre.
std::string ToSph(const SphTree& tree, double metres_per_unit);

/// Of a tree of our own: its root is the ball that holds all leaves, and its degree is 8, so that
/// it has a level more than the tree.  Balls of inner levels are those that bound what is below
/// them.
/// @param levels  how many levels of the tree below the root; 0: all.
/// Throws Error where the slots of all nodes are too many.
SphTree SphOf(const SphereTree& tree, int levels = 0);

/// The balls that stand for the solid at a level: those of its row, and those of coarser rows that
/// have no children, where the toolkit found nothing to refine.
/// @param level  from 1, the root, to tree.levels.
std::vector<Sphere> BallsOfLevel(const SphTree& tree, int level);

}  // namespace palpate
