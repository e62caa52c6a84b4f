#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

/// Represents a library whose package was not installed.
[[maybe_unused]] PeerKind Missing(std::string id, std::string name, std::string package) {
  return {.id = std::move(id), .name = std::move(name), .package = std::move(package)};
}

}  // namespace

const std::vector<PeerKind>& PeerKinds() {
  static const std::vector<PeerKind> kinds = {
#ifdef PALPATE_PEER_BULLET
      BulletPeer(),
#else
      Missing("bullet", "Bullet", "libbullet-dev"),
#endif
#ifdef PALPATE_PEER_ODE
      OdePeer(),
#else
      Missing("ode", "ODE", "libode-dev"),
#endif
#ifdef PALPATE_PEER_MUJOCO
      MujocoPeer(),
#else
      Missing("mujoco", "MuJoCo", "libmujoco-dev"),
#endif
  };
  return kinds;
}

std::string HowToInstall(const PeerKind& kind) {
  return "was not installed when this was configured: `apt-get install " + kind.package +
         "`, then configure and build anew";
}

}  // namespace palpate::bench
