#include "client/viewer/scene_packer.h"

#include <utility>

#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <zlib.h>

namespace palpate {
namespace {

/// Returns the bytes as a gzip file, at zlib's fastest level: 20 ms per megabyte.  Null if memory
/// is lacking or there are more than 4 GB.
PackedScene::Bytes Gzip(std::span<const std::uint8_t> bytes) {
  z_stream stream{};
  constexpr int kGzipHeader = 16;
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS + kGzipHeader, MAX_MEM_LEVEL,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    return nullptr;
  }
  std::vector<std::uint8_t> packed(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  const bool is_whole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return is_whole ? std::make_shared<const std::vector<std::uint8_t>>(std::move(packed)) : nullptr;
}

}  // namespace

void ScenePacker::Pack(const SceneBytes& scene,
                       std::function<void(const PackedScene::Bytes&)> use) {
  PackedScene& packed = *scene.packed;
  if (packed.bytes) return use(packed.bytes);
  packed.waiting.push_back(std::move(use));
  if (packed.waiting.size() > 1) return;
  boost::asio::post(packer_, [this, scene] {
    // Low priority: the servo loops on this host have little time to spare.
    setpriority(PRIO_PROCESS, 0, 10);  // of this thread alone, on Linux
    boost::asio::post(io_, [scene, bytes = Gzip(scene.bundle)] {
      if (!bytes)
        spdlog::warn("zlib cannot compress a scene of {} bytes: it is sent uncompressed",
                     scene.bundle.size());
      scene.packed->bytes = bytes;
      for (const auto& waiting : std::exchange(scene.packed->waiting, {})) waiting(bytes);
    });
  });
}

}  // namespace palpate
