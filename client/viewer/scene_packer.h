#pragma once

#include <functional>

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>

#include "client/viewer/topic_feed.h"

namespace palpate {

/// Compresses scene bundles, each once, in its own thread.
/// Thread contract: the thread that runs `io`.  The destructor waits for a running compression.
class ScenePacker {
 public:
  explicit ScenePacker(boost::asio::io_context& io) : io_(io) {}
  ~ScenePacker() { packer_.join(); }

  /// Calls `use` with the bundle as a gzip file, at once or when it is ready.  Null: it failed.
  void Pack(const SceneBytes& scene, std::function<void(const PackedScene::Bytes&)> use);

 private:
  boost::asio::io_context& io_;
  boost::asio::thread_pool packer_{1};
};

}  // namespace palpate
