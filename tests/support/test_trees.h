#pragma once

#include <span>
#include <vector>

#include "scenes/sphere_tree.h"
#include "tests/support/random.h"

namespace palpate::test {

struct Ball {
  Vec3 center;
  double radius;
};

/// Builds a sphere tree over given balls by halving along the longest axis: a second, simple
/// builder, so that the physics is tested without the one that scenes use.
SphereTree MakeTree(std::span<const Ball> balls);

/// `count` balls of about `radius` in the cube of half side `half`.
std::vector<Ball> RandomBalls(Random& random, int count, double half, double radius);

/// Balls of `radius` on a square grid in the plane z = -radius, so that z = 0 is touched by each.
std::vector<Ball> Floor(double half, double spacing, double radius);

/// Balls that fill the surface of a sphere of radius `outer` from inside.
std::vector<Ball> Shell(int count, double outer, double radius);

}  // namespace palpate::test
