#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_tree.h"

namespace palpate {

/// Triangle mesh in metres.  Faces are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< mesh frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A rigid body of the scene: its mesh and its sphere tree share one frame B.
struct Body {
  std::string name;
  TriangleMesh mesh;  ///< frame B [m]
  SphereTree tree;    ///< frame B [m]
  Pose X_WB;          ///< objects: where they stand.  Tools: where the tool starts.
};

/// The virtual coupling between haptic and graphic tool (chapter 2.3: G, eqs. 2.20-2.24).
struct Coupling {
  double stiffness = 1000.0;         ///< k_t [N/m]
  double torsional_stiffness = 1.0;  ///< k_r [N m/rad]
};

/// A scene, compiled: what the server loads and the wire carries (scene_bundle.h).  Immutable.
struct Scene {
  std::string name;
  std::vector<Body> tools;    ///< moved by hands, one station each
  std::vector<Body> objects;  ///< fixed in W
  Coupling coupling;
};

}  // namespace palpate
