#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "client/viewer/foxglove.h"
#include "client/viewer/frame_queue.h"
#include "client/viewer/hub.h"
#include "client/viewer/signs_of_life.h"
#include "client/viewer/viewer_limits.h"
#include "client/viewer/visitor.h"
#include "client/viewer/web_stream.h"
#include "common/realtime/rate_limit.h"
#include "common/realtime/token_bucket.h"

namespace palpate {

/// One viewer's WebSocket.  At most one write is in flight; frames that arrive meanwhile wait in
/// the viewer's own FrameQueue.  A violation of the protocol closes this socket with a status that
/// says why, and affects nothing else.
/// Thread contract: the network thread.  Lives as long as the hub or a handler holds it.
class ViewerSession : public std::enable_shared_from_this<ViewerSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// @param verdict  what it may do, and its token's holder.
  ViewerSession(WebStream stream, Hub& hub, std::uint64_t id, Visitor visitor,
                const Verdict& verdict);

  /// Answers the handshake, then reads and writes until the viewer has gone.
  void Accept(const Request& request, std::string_view subprotocol);

  std::uint64_t id() const { return id_; }
  const Visitor& visitor() const { return visitor_; }
  /// It may operate in a course.
  bool teaches() const { return teaches_; }
  const std::optional<Tokens::Holder>& holder() const { return holder_; }
  /// Takes over its token's new name.
  void Rename(const std::string& name) { holder_->name = name; }
  std::uint64_t frames_lost() const { return queue_.lost(); }
  std::uint64_t frames_sent() const { return frames_sent_; }

  void Push(const FramePtr& frame, std::int64_t now_ns) { queue_.Push(frame, now_ns); }
  /// Writes a text or a frame that is due, unless a write is in flight.
  void Flush(std::int64_t now_ns);
  /// Sends the viewer a status message, within the rate of ViewerLimits; the next one tells how
  /// many were left out.
  void Say(foxglove::Level level, const std::string& message);
  /// The token's name and the address, for the log and for wishes sent on.
  std::string Who() const;
  void TellMouseState(const FramePtr& frame);
  /// Checks that a viewer which holds a tool is alive, and that a closing one ends in time.
  void Watch(std::int64_t now_ns);
  /// Ends the connection at once, without a message; also called when the viewer has gone.
  void Gone();
  /// Closes in order, after the waiting texts are sent; a viewer that takes more than 2 s is
  /// dropped.  Its messages are ignored from now on.
  void Close(boost::beast::websocket::close_code code, const std::string& reason);

 private:
  void Open();
  void Read();
  void OnRead(boost::beast::error_code error);
  /// Reads on, at once or after a pause.
  void ReadOn(std::int64_t now_ns);
  /// Returns what is wrong with the message; empty: nothing.
  std::string OnText(std::string_view text);
  std::string OnBinary(std::span<const std::uint8_t> bytes);
  void Subscribe(const foxglove::Request& request);
  void Publish(const foxglove::ClientChannel& channel);
  /// Returns what a client may publish, or why it may not publish.
  std::string WhatIsOfUse() const;
  using Take = void (ViewerSession::*)(std::string_view payload);
  /// A topic on which clients may publish.
  struct Topic {
    const char* name;
    bool may;  ///< this client may
    Take take;
  };
  std::array<Topic, 6> Topics() const;
  void OnMouse(std::string_view payload);
  void OnReplay(std::string_view payload);
  void OnClass(std::string_view payload);
  void OnExam(std::string_view payload);
  void OnTrial(std::string_view payload);
  /// The channels that it is offered.
  std::vector<foxglove::Channel> Channels() const;
  void OnOperate(std::string_view payload);
  void Send(std::string text);
  void Write();
  void OnWritten(boost::beast::error_code error);

  boost::beast::websocket::stream<WebStream, false> socket_;  // false: no compression
  Hub& hub_;
  std::uint64_t id_;
  Visitor visitor_;
  Access access_;
  std::optional<Tokens::Holder> holder_;  // of its token
  bool mouse_;                            // it may have a mouse
  bool steers_;                           // it may steer a replay
  bool of_course_;                        // its token belongs to a person
  bool teaches_;
  boost::beast::flat_buffer input_;
  TokenBucket messages_{ViewerLimits::kMessagesPerSecond, ViewerLimits::kMessagesAtOnce};
  RateLimit complaints_{ViewerLimits::kComplaints.period_ns, ViewerLimits::kComplaints.at_once};
  boost::asio::steady_timer rest_;
  bool told_of_flood_ = false;

  std::deque<std::string> texts_;
  std::size_t texts_size_ = 0;  // total size [bytes]
  FrameQueue queue_;
  bool open_ = false;
  bool writing_ = false;
  bool closing_ = false;
  std::int64_t closing_ns_ = 0;  // when closing began
  bool gone_ = false;
  boost::beast::websocket::close_reason close_reason_;
  // What is being written.
  std::string text_;
  FrameQueue::Next frame_;
  foxglove::MessageHeader header_{};

  std::map<std::uint32_t, Take> published_;  // by the client's channel
  FramePtr mouse_state_;
  SignsOfLife signs_;
  bool pinging_ = false;
  std::uint64_t frames_sent_ = 0;
};

}  // namespace palpate
