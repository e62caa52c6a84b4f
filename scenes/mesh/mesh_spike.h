#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A vertex far away from all others, as a scanner error or a lost digit produces one.
struct Spike {
  Vec3 at = Vec3::Zero();  ///< [the mesh's unit]
  double longest = 0.0;    ///< longest side of the mesh's box [the same]
  double without = 0.0;    ///< what that side would be without the vertex [the same]

  /// Returns whether it is certainly a mistake: no body that a hand feels is so elongated.
  bool certain() const { return longest > 1000.0 * without; }
};

/// Returns the vertex whose removal shortens the bounding box most, if that is by at least a third
/// of its longest side, and all of the vertex's edges are at least ten times the median edge.  The
/// tip of a cone may be one, too: people have to decide.
/// @param mesh  not refused by InspectMesh.
std::optional<Spike> FindSpike(const TriangleMesh& mesh);

/// Returns the remark for people, with the remedy.
std::string SpikeRemark(const Spike& spike);

}  // namespace palpate
