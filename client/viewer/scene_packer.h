#pragma once

#include <functional>

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>

#include "client/viewer/topic_feed.h"

namespace palpate {

/// Bundles of scenes, each compressed once, by a thread of its own.
/// Thread contract: the thread that runs `io`.  The destructor waits for what is being compressed.
class ScenePacker {
 public:
  explicit ScenePacker(boost::asio::io_context& io) : io_(io) {}
  ~ScenePacker() { packer_.join(); }

  /// Gives `use` these very bytes as a gzip file: now, or once that is done.  Null: it failed.
  void Pack(const SceneBytes& scene, std::function<void(const PackedScene::Bytes&)> use);

 private:
  boost::asio::io_context& io_;
  boost::asio::thread_pool packer_{1};
};

}  // namespace palpate
