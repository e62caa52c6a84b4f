#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A vertex far out of all others, as a scanner or a lost digit leaves one.
struct Spike {
  Vec3 at = Vec3::Zero();  ///< [the mesh's unit]
  double longest = 0.0;    ///< side of the mesh's box [the same]
  double without = 0.0;    ///< what it would be without the vertex [the same]

  /// No body that a hand feels is so much longer than it is wide: it is a mistake for certain.
  bool certain() const { return longest > 1000.0 * without; }
};

/// The vertex without which the box would be most shorter, where that is a third of its longest
/// side at least, and all of the vertex's edges are ten times as long as half of the mesh's are.
/// A cone's tip is one, too: people have to tell.
/// @param mesh  not refused by InspectMesh.
std::optional<Spike> FindSpike(const TriangleMesh& mesh);

/// For people, with the remedy.
std::string SpikeRemark(const Spike& spike);

}  // namespace palpate
