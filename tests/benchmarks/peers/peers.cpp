#include <filesystem>

#include <dlfcn.h>
#include <spdlog/fmt/fmt.h>

#include "common/error.h"
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

std::vector<PeerKind> PeersOf(const std::string& file) {
  // As a path, since dlopen would look for a bare name among the system's libraries.
  const std::filesystem::path path = std::filesystem::absolute(file);
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw UsageError(fmt::format("--peers {}: {}", file, dlerror()));
  auto* add = reinterpret_cast<AddPeerKinds*>(dlsym(library, kPeersFunction));
  if (!add) {
    throw UsageError(fmt::format(
        "--peers {}: has no function {}; tests/benchmarks/peers/peer.h says what it should do",
        file, kPeersFunction));
  }
  std::vector<PeerKind> kinds;
  add(kinds);
  for (PeerKind& kind : kinds) kind.package = path.filename();
  return kinds;
}

std::string HowToInstall(const PeerKind& kind) {
  return "was not installed when this was configured: `apt-get install " + kind.package +
         "`, then configure and build anew";
}

}  // namespace palpate::bench
