#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/support/random.h"

namespace palpate::bench {

// What hands over bodies with a truth have in common.

inline constexpr int kDown = 300;         ///< steps in which a hand comes down on the body
inline constexpr double kAbove = 1e-3;    ///< from so far above [m]
inline constexpr double kTremor = 20e-6;  ///< [m]
inline constexpr double kTremorHz = 8.0;

/// Returns the depth of a hand at a step: from above down to `depth`, with tremor [m].
inline double DepthAt(int step, double depth) {
  const double pressed = std::min(1.0, static_cast<double>(step) / kDown), t = 1e-3 * step;
  return -kAbove + (depth + kAbove) * pressed + kTremor * std::sin(2.0 * M_PI * kTremorHz * t);
}

/// Returns a number whose logarithm is spread evenly.
inline double Decades(test::Random& random, double low, double high) {
  return low * std::pow(high / low, random.Uniform(0.0, 1.0));
}

/// Returns how far the tool's farthest point is from its centroid [m].
inline double ReachOf(const Body& tool) {
  double reach = 0.0;
  for (const Vec3& v : tool.mesh.vertices) {
    reach = std::max(reach, (v - tool.tree.centroid).norm());
  }
  return reach;
}

/// Makes an object that is felt by its mesh alone.  One leaf stands for all of it: to fit more into
/// a million triangles, or to close what only T-junctions close, takes longer than a hand.
inline Body SurfaceBody(std::string name, TriangleMesh mesh) {
  Body body;
  body.name = std::move(name);
  body.tree = SingleSphereTree(mesh, {mesh.vertices.front(), 1e-6});
  body.mesh = std::move(mesh);
  return body;
}

/// Returns a seed for a case and a seed, so that no two cases have hands in common (FNV-1a).
inline std::uint64_t SeedOf(std::string_view name, std::uint64_t seed) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash + seed;
}

}  // namespace palpate::bench
