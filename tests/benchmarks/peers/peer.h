#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::bench {

/// The scene that a peer must simulate: one tool against fixed objects, as meshes.  The objects
/// pointed to must outlive the peer.
struct PeerScene {
  struct Object {
    const TriangleMesh* mesh = nullptr;
    Pose X_WB;
  };
  const TriangleMesh* tool = nullptr;  ///< frame T [m]
  Vec3 centroid = Vec3::Zero();        ///< point at which coupling and wrench act, in T [m]
  /// The radius [m] if the tool is a ball round `centroid`: a peer then uses its own exact sphere,
  /// which works better than a mesh.
  std::optional<double> ball{};
  std::vector<Object> objects{};
  Coupling coupling{};
};

/// @field X_WG      pose of the peer's tool after the step.
/// @field wrench    wrench of the spring between X_WH and X_WG on the hand (chapter 2.20-2.24).
struct PeerStep {
  Pose X_WG;
  Wrench wrench;
  int contacts = 0;
};

/// Haptic rendering of the same scene by another library, one step per millisecond.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual PeerStep Step(const Pose& X_WH) = 0;
};

/// A library to compare Palpate with.
struct PeerKind {
  std::string id;         ///< argument of --peers
  std::string name;       ///< as spelled by its authors
  std::string package;    ///< Debian package to build with, or the file that it was loaded from
  std::string version{};  ///< empty: the package was not installed when this program was configured
  /// What it does and its settings, for the report.
  std::string settings{};
  bool convex = false;  ///< it uses the convex hulls of meshes for collisions, not the meshes
  /// Makes a peer at rest at X_WG = `start`.  Throws Error.
  std::function<std::unique_ptr<Peer>(const PeerScene&, const Pose& start)> make{};

  bool installed() const { return !version.empty(); }
};

/// Returns all kinds that this program supports, installed or not.
const std::vector<PeerKind>& PeerKinds();

/// The name of the function that a library of one's own defines for --peers FILE.  It appends
/// kinds, whose `package` it leaves empty:
///   extern "C" void PalpatePeers(std::vector<palpate::bench::PeerKind>& kinds);
/// It is built with this header, and with the compiler and instruction set of palpate-bench, since
/// objects of C++ cross between them.
inline constexpr const char* kPeersFunction = "PalpatePeers";
using AddPeerKinds = void(std::vector<PeerKind>& kinds);

/// Returns the kinds of such a library.  It stays loaded.  Throws UsageError that names the file.
std::vector<PeerKind> PeersOf(const std::string& file);

/// Returns, for a kind that is not installed, the package to install and what to do then.
std::string HowToInstall(const PeerKind& kind);

// One function for each file in this folder.
PeerKind BulletPeer();
PeerKind OdePeer();
PeerKind MujocoPeer();

}  // namespace palpate::bench
