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

/// Who a viewer is.
struct Guest {
  std::uint64_t id = 0;
  Visitor visitor;
  std::optional<Tokens::Holder> holder;  ///< of its token
  bool teaches = false;                  ///< it may operate in a course

  /// Returns the person of the course; 0: none.
  std::int64_t person() const { return holder ? holder->person : 0; }
  /// Returns the token's name and the address, for the log and for wishes sent on.
  std::string Who() const { return (holder ? holder->name : "the page") + " at " + visitor.name; }
};

/// One viewer as the hub knows it: who it is, and the frames that wait for it.  The connection
/// behind it (viewer_session.h) knows the hub; the hub knows only this.
/// Thread contract: the network thread.
class Viewer {
 public:
  explicit Viewer(Guest guest) : guest_(std::move(guest)) {}
  virtual ~Viewer() = default;

  const Guest& guest() const { return guest_; }
  std::uint64_t id() const { return guest_.id; }
  /// Takes over its token's new name.
  void Rename(const std::string& name, const std::string& station) {
    guest_.holder->name = name;
    guest_.holder->station = station;
  }

  void Push(const FramePtr& frame, std::int64_t now_ns) { queue_.Push(frame, now_ns); }
  struct Frames {
    std::uint64_t sent = 0, lost = 0;
  };
  Frames frames() const { return {frames_sent_, queue_.lost()}; }

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
  Guest guest_;
};

}  // namespace palpate
