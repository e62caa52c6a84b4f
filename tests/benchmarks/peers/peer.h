#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::bench {

/// What a peer is asked to simulate: one tool against fixed objects, as meshes.  What it points to
/// must outlive the peer.
struct PeerScene {
  struct Object {
    const TriangleMesh* mesh = nullptr;
    Pose X_WB;
  };
  const TriangleMesh* tool = nullptr;  ///< frame T [m]
  Vec3 centroid = Vec3::Zero();        ///< where coupling and wrench act, in T [m]
  /// Where the tool is a ball round `centroid`, its radius [m]: a peer takes its own exact sphere
  /// then, which it is better at than at any mesh of one.
  std::optional<double> ball{};
  std::vector<Object> objects{};
  Coupling coupling{};
};

/// What a peer may be set to, beside what its own file chooses and explains.
struct PeerSettings {
  double mass = 0.1;  ///< of the tool [kg]
  int substeps = 1;   ///< of the millisecond
};

/// @field X_WG      where the peer's tool is after the step.
/// @field wrench    of the spring between X_WH and X_WG, on the hand (chapter 2.20-2.24).
struct PeerStep {
  Pose X_WG;
  Wrench wrench;
  int contacts = 0;
};

/// Another library's rendering of the same scene, one step a millisecond.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual PeerStep Step(const Pose& X_WH) = 0;
};

/// A library that Palpate is measured beside.
struct PeerKind {
  std::string id;         ///< as --peers takes it
  std::string name;       ///< as its authors write it
  std::string package;    ///< Debian's, that it is built with
  std::string version{};  ///< empty: the package was not there when this program was configured
  /// What it does and how it is set, for the report.
  std::string settings{};
  bool convex = false;  ///< it collides the convex hulls of meshes, not the meshes
  /// A new one at rest at X_WG = `start`.  Throws Error.
  std::function<std::unique_ptr<Peer>(const PeerScene&, const Pose& start, const PeerSettings&)>
      make{};

  bool installed() const { return !version.empty(); }
};

/// All that this program knows, installed or not.
const std::vector<PeerKind>& PeerKinds();

/// Of a kind that is not installed: the package that brings it, and what to do then.
std::string HowToInstall(const PeerKind& kind);

// One for each file beside this one.
PeerKind BulletPeer();
PeerKind OdePeer();
PeerKind MujocoPeer();

}  // namespace palpate::bench
