#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
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
#include "client/viewer/viewer.h"
#include "client/viewer/viewer_limits.h"
#include "client/viewer/web_stream.h"
#include "common/realtime/rate_limit.h"
#include "common/realtime/token_bucket.h"

namespace palpate {

/// A viewer's WebSocket.  At most one write is in flight; frames that arrive meanwhile wait in
/// the viewer's own FrameQueue.  A violation of the protocol closes this socket with a status that
/// says why, and affects nothing else.
/// Thread contract: the network thread.  Lives as long as the hub or a handler holds it.
class ViewerSession : public Viewer, public std::enable_shared_from_this<ViewerSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// @param verdict  what it may do, and its token's holder.
  ViewerSession(WebStream stream, Hub& hub, std::uint64_t id, const Visitor& visitor,
                const Verdict& verdict);

  /// Answers the handshake, then reads and writes until the viewer has gone.
  void Accept(const Request& request, std::string_view subprotocol);

  void Flush(std::int64_t now_ns) override;
  void Say(foxglove::Level level, const std::string& message) override;
  void TellMouseState(const FramePtr& frame) override;
  void Watch(std::int64_t now_ns) override;
  void Gone() override;
  void Close(boost::beast::websocket::close_code code, const std::string& reason) override;

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
  Access access_;
  bool mouse_;      // it may have a mouse
  bool steers_;     // it may steer a replay
  bool of_course_;  // its token belongs to a person
  boost::beast::flat_buffer input_;
  TokenBucket messages_{ViewerLimits::kMessagesPerSecond, ViewerLimits::kMessagesAtOnce};
  RateLimit complaints_{ViewerLimits::kComplaints.period_ns, ViewerLimits::kComplaints.at_once};
  boost::asio::steady_timer rest_;
  bool told_of_flood_ = false;

  std::deque<std::string> texts_;
  std::size_t texts_size_ = 0;  // total size [bytes]
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
};

}  // namespace palpate
