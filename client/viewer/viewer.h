#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <boost/beast/websocket/rfc6455.hpp>

#include "client/viewer/foxglove.h"
#include "client/viewer/frame_queue.h"
#include "client/viewer/tokens.h"
#include "client/viewer/visitor.h"

namespace palpate {

/// One viewer as the hub knows it: who it is, and the frames that wait for it.  The connection
/// behind it (viewer_session.h) knows the hub; the hub knows only this.
/// Thread contract: the network thread.
class Viewer {
 public:
  /// @param teaches  it may operate in a course.
  Viewer(std::uint64_t id, Visitor visitor, std::optional<Tokens::Holder> holder, bool teaches)
      : id_(id), visitor_(std::move(visitor)), holder_(std::move(holder)), teaches_(teaches) {}
  virtual ~Viewer() = default;

  std::uint64_t id() const { return id_; }
  const Visitor& visitor() const { return visitor_; }
  bool teaches() const { return teaches_; }
  /// The holder of its token.
  const std::optional<Tokens::Holder>& holder() const { return holder_; }
  /// Takes over its token's new name.
  void Rename(const std::string& name, const std::string& station) {
    holder_->name = name;
    holder_->station = station;
  }
  /// The token's name and the address, for the log and for wishes sent on.
  std::string Who() const {
    return (holder_ ? holder_->name : "the page") + " at " + visitor_.name;
  }

  void Push(const FramePtr& frame, std::int64_t now_ns) { queue_.Push(frame, now_ns); }
  std::uint64_t frames_lost() const { return queue_.lost(); }
  std::uint64_t frames_sent() const { return frames_sent_; }

  /// Writes a text or a frame that is due, unless a write is in flight.
  virtual void Flush(std::int64_t now_ns) = 0;
  /// Sends the viewer a status message, within the rate of ViewerLimits; the next one tells how
  /// many were left out.
  virtual void Say(foxglove::Level level, const std::string& message) = 0;
  virtual void TellMouseState(const FramePtr& frame) = 0;
  /// Checks that a viewer which holds a tool is alive, and that a closing one ends in time.
  virtual void Watch(std::int64_t now_ns) = 0;
  /// Ends the connection at once, without a message; also called when the viewer has gone.
  virtual void Gone() = 0;
  /// Closes in order, after the waiting texts are sent; a viewer that takes more than 2 s is
  /// dropped.  Its messages are ignored from now on.
  virtual void Close(boost::beast::websocket::close_code code, const std::string& reason) = 0;

 protected:
  FrameQueue queue_;
  std::uint64_t frames_sent_ = 0;

 private:
  std::uint64_t id_;
  Visitor visitor_;
  std::optional<Tokens::Holder> holder_;
  bool teaches_;
};

}  // namespace palpate
