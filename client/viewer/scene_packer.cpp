#include "client/viewer/scene_packer.h"

#include <algorithm>
#include <utility>

#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include "client/viewer/gzip.h"
#include "common/error.h"

namespace palpate {

void ScenePacker::Pack(const SceneBytes& scene, std::function<void(const Bytes&)> use) {
  Packed& packed = packed_[scene.hash];
  if (packed.bytes) return use(packed.bytes);
  packed.waiting.push_back(std::move(use));
  if (packed.waiting.size() > 1) return;
  boost::asio::post(packer_, [this, scene] {
    // It may take its time: the servo loops' host has little to spare.
    setpriority(PRIO_PROCESS, 0, 10);  // of this thread alone, on Linux
    Bytes bytes;
    try {
      bytes = std::make_shared<const std::vector<std::uint8_t>>(Gzip(scene.bundle));
    } catch (const Error& error) {
      spdlog::warn("a scene is sent as it is: {}", error.what());
    }
    boost::asio::post(io_, [this, hash = scene.hash, bytes] { Done(hash, bytes); });
  });
}

void ScenePacker::Done(std::uint64_t hash, const Bytes& bytes) {
  Packed& packed = packed_[hash];
  packed.bytes = bytes;
  for (const auto& waiting : std::exchange(packed.waiting, {})) waiting(bytes);
}

void ScenePacker::KeepOnly(const std::map<std::string, SceneBytes>& scenes) {
  std::erase_if(packed_, [&](const auto& entry) {
    return entry.second.waiting.empty() && std::ranges::none_of(scenes, [&](const auto& scene) {
             return scene.second.hash == entry.first;
           });
  });
}

}  // namespace palpate
