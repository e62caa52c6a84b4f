#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>

#include "client/viewer/topic_feed.h"

namespace palpate {

/// Bundles of scenes, each compressed once, by a thread of its own.
/// Thread contract: the thread that runs `io`.  The destructor waits for what is being compressed.
class ScenePacker {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

  explicit ScenePacker(boost::asio::io_context& io) : io_(io) {}
  ~ScenePacker() { packer_.join(); }

  /// Gives `use` these very bytes compressed: now, or once that is done.  Null: it failed.
  void Pack(const SceneBytes& scene, std::function<void(const Bytes&)> use);
  /// Forgets all that is no scene's any more.
  void KeepOnly(const std::map<std::string, SceneBytes>& scenes);

 private:
  struct Packed {
    Bytes bytes;
    std::vector<std::function<void(const Bytes&)>> waiting;
  };
  void Done(std::uint64_t hash, const Bytes& bytes);

  boost::asio::io_context& io_;
  std::map<std::uint64_t, Packed> packed_;  // by the bundle's hash: a name may get another one
  boost::asio::thread_pool packer_{1};
};

}  // namespace palpate
