#include "client/viewer/viewer_session.h"

#include <algorithm>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace net = boost::asio;
namespace websocket = beast::websocket;

/// What the kernel buffers for a stalled viewer: some seconds of tool states.
constexpr int kSendBuffer = 64 * 1024;
/// What the kernel buffers of its unread input: one largest message, so that a flood is over a
/// second after its sender has gone.
constexpr int kReceiveBuffer = 64 * 1024;
constexpr const char* kOperateTopic = "/palpate/operate";
constexpr const char* kTrialTopic = "/palpate/trial";

}  // namespace

ViewerSession::ViewerSession(WebStream stream, Hub& hub, std::uint64_t id, const Visitor& visitor,
                             const Verdict& verdict)
    : Viewer({id, visitor, verdict.holder, hub.course() && verdict.access == Access::kOperate}),
      socket_(std::move(stream)),
      hub_(hub),
      access_(verdict.access),
      mouse_(access_ >= Access::kDrive && hub.options().max_mice > 0),
      steers_(access_ >= Access::kDrive && !hub.options().no_steering),
      of_course_(hub.course() && guest().person() != 0),
      rest_(socket_.get_executor()) {}

std::vector<foxglove::Channel> ViewerSession::Channels() const {
  return ChannelsFor(mouse_, steers_, of_course_, guest().teaches);
}

void ViewerSession::Accept(const Request& request, std::string_view subprotocol) {
  beast::tcp_stream& stream = socket_.next_layer().next_layer();
  stream.expires_never();  // the WebSocket has its own timeouts
  boost::system::error_code ignored;
  stream.socket().set_option(net::ip::tcp::no_delay(true), ignored);
  stream.socket().set_option(net::socket_base::send_buffer_size(kSendBuffer), ignored);
  stream.socket().set_option(net::socket_base::receive_buffer_size(kReceiveBuffer), ignored);
  websocket::stream_base::timeout times{};
  times.handshake_timeout = std::chrono::seconds(10);
  times.idle_timeout = std::chrono::seconds(30);
  times.keep_alive_pings = true;
  socket_.set_option(times);
  socket_.set_option(websocket::stream_base::decorator(
      [name = std::string(subprotocol)](websocket::response_type& response) {
        response.set(beast::http::field::server, "palpate-viewer/" PALPATE_VERSION);
        response.set(beast::http::field::sec_websocket_protocol, name);
      }));
  socket_.read_message_max(ViewerLimits::kLargestMessage);
  socket_.next_layer().LimitReading(ViewerLimits::kBytesPerSecond, ViewerLimits::kBytesAtOnce);
  socket_.auto_fragment(false);  // a message is one frame, written without a copy
  socket_.control_callback([this](websocket::frame_type, beast::string_view) { signs_.Heard(); });
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) {
      self->Gone();
    } else {
      self->Open();
    }
  });
}

void ViewerSession::Open() {
  open_ = true;
  signs_.Heard();
  spdlog::debug("viewer {} has come", guest().Who());
  const bool publishes = mouse_ || steers_ || access_ == Access::kOperate;
  Send(foxglove::ServerInfo(hub_.viewers().session_id(), publishes, RoleName(access_)));
  Send(foxglove::Advertise(Channels()));
  Read();
}

void ViewerSession::Gone() {
  if (std::exchange(gone_, true)) return;
  open_ = false;
  spdlog::debug("viewer {} has gone", guest().Who());
  rest_.cancel();
  socket_.next_layer().next_layer().close();
  hub_.Leave(*this);
}

// --- receiving ---

void ViewerSession::Read() {
  socket_.async_read(input_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    self->OnRead(error);
  });
}

void ViewerSession::OnRead(beast::error_code error) {
  if (error) {
    // If a frame violated RFC 6455, Beast has already closed the socket with the matching code.
    return Gone();
  }
  const std::int64_t now_ns = SteadyNanoseconds();
  signs_.Heard();
  if (closing_) return input_.clear();
  const auto data = input_.cdata();
  std::string wrong;
  try {
    wrong = socket_.got_text()
                ? OnText({static_cast<const char*>(data.data()), data.size()})
                : OnBinary({static_cast<const std::uint8_t*>(data.data()), data.size()});
  } catch (const Error& refused) {
    wrong = refused.what();
  }
  input_.clear();
  if (!wrong.empty()) {
    Send(foxglove::Status(foxglove::Level::kError, "this connection ends: it sent " + wrong));
    return Close(websocket::close_code::policy_error, "not of the protocol");
  }
  Flush(now_ns);
  ReadOn(now_ns);
}

void ViewerSession::ReadOn(std::int64_t now_ns) {
  if (gone_) return;
  messages_.Spend(1.0, now_ns);
  const std::int64_t wait_ns = messages_.WaitFor(1.0, now_ns);
  if (wait_ns == 0) return Read();
  // Excess input waits in the network; nothing of it is stored here.
  const std::string why = "this client sends more than " +
                          std::to_string(static_cast<int>(ViewerLimits::kMessagesPerSecond)) +
                          " messages a second; they are read later";
  if (!std::exchange(told_of_flood_, true)) Say(foxglove::Level::kWarning, why);
  hub_.viewers().refusals().Say(Refusal::kFlood, guest().Who(), why, now_ns);
  rest_.expires_after(std::chrono::nanoseconds(wait_ns));
  rest_.async_wait([self = shared_from_this()](boost::system::error_code stopped) {
    if (!stopped && !self->gone_) self->Read();
  });
}

std::string ViewerSession::OnText(std::string_view text) {
  const foxglove::Request request = foxglove::ParseRequest(text);
  if (request.op == "subscribe") {
    Subscribe(request);
  } else if (request.op == "unsubscribe") {
    for (const std::uint32_t id : request.ids) queue_.Unsubscribe(id);
  } else if (request.op == "advertise") {
    for (const foxglove::ClientChannel& channel : request.channels) {
      if (published_.size() >= ViewerLimits::kMostChannels) return "too many channels";
      Publish(channel);
    }
  } else if (request.op == "unadvertise") {
    for (const std::uint32_t id : request.ids) published_.erase(id);
  } else {
    Say(foxglove::Level::kWarning, Quoted(request.op) + " is nothing that this gateway does");
  }
  return "";
}

std::array<ViewerSession::Topic, 6> ViewerSession::Topics() const {
  return {{{"/palpate/replay", steers_, &ViewerSession::OnReplay},
           {"/palpate/mouse", mouse_, &ViewerSession::OnMouse},
           {kOperateTopic, access_ == Access::kOperate, &ViewerSession::OnOperate},
           {"/palpate/class", guest().teaches, &ViewerSession::OnClass},
           {"/palpate/exam", guest().teaches, &ViewerSession::OnExam},
           {kTrialTopic, of_course_ && mouse_, &ViewerSession::OnTrial}}};
}

void ViewerSession::Publish(const foxglove::ClientChannel& channel) {
  for (const Topic& topic : Topics()) {
    if (!topic.may || channel.topic != topic.name || channel.encoding != "json") continue;
    published_.insert_or_assign(channel.id, topic.take);
    return;
  }
  const std::string why =
      "channel " + Quoted(channel.topic) + " is of no use here: " + WhatIsOfUse();
  Say(foxglove::Level::kWarning, why);
  hub_.viewers().refusals().Say(Refusal::kRole, guest().Who(), why, SteadyNanoseconds());
}

std::string ViewerSession::WhatIsOfUse() const {
  if (access_ < Access::kDrive) {
    return hub_.rights().gate().tokens()
               ? "this client may only watch: its token's role is watch, or its page is not from "
                 "this gateway"
               : "this client may look, and publish nothing (palpate-viewer --allow-origin)";
  }
  const bool operates = access_ == Access::kOperate;
  std::string use;
  for (const Topic& topic : Topics()) {
    if (topic.may) use += (use.empty() ? "give " : " or ") + std::string(topic.name);
  }
  if (!use.empty()) use += ", encoding json";
  const auto add = [&](const char* reason) {
    use += (use.empty() ? "" : "; ") + std::string(reason);
  };
  if (!operates) {
    add(hub_.rights().gate().tokens()
            ? "to decide about stations is for tokens of the role operate, on this gateway's page"
            : "to decide about stations is for pages at the gateway's own host, or for tokens of "
              "the "
              "role operate (palpate-viewer --tokens)");
  }
  if (!mouse_) add("this gateway lets nobody take a tool (palpate-viewer --max-mice)");
  if (!steers_) add("this gateway lets nobody steer a replay (palpate-viewer --no-steering)");
  return use;
}

void ViewerSession::Subscribe(const foxglove::Request& request) {
  const std::int64_t now_ns = SteadyNanoseconds();
  const std::vector<foxglove::Channel> channels = Channels();
  for (const foxglove::Subscription& wanted : request.subscriptions) {
    const bool known =
        std::ranges::find(channels, wanted.channel, &foxglove::Channel::id) != channels.end();
    if (!known || queue_.subscribed(wanted.channel) || queue_.has_subscription(wanted.id)) {
      Say(foxglove::Level::kWarning,
          "subscription " + std::to_string(wanted.id) + " to channel " +
              std::to_string(wanted.channel) +
              (known ? " is refused: the channel or the id has one already; unsubscribe first"
                     : " is refused: there is no such channel"));
      continue;
    }
    const bool rated =
        wanted.channel == TopicFeed::kToolState || wanted.channel == TopicFeed::kMovedState;
    if (!hub_.viewers().Refuse(Wish::kSubscribe, *this, now_ns).empty()) continue;
    queue_.Subscribe(wanted.channel, wanted.id,
                     rated ? static_cast<std::int64_t>(1e9 / hub_.options().rate_hz) : 0);
    hub_.viewers().places().Subscribed(id());
    for (const FramePtr& frame : hub_.feed().Kept(wanted.channel)) queue_.Push(frame, now_ns);
    if (wanted.channel == TopicFeed::kGoal) {
      for (const auto& [scene, goal] : hub_.server().goals()) queue_.Push(goal, now_ns);
    }
    if (hub_.course() != nullptr) {
      const FramePtr kept = hub_.course()->Kept(wanted.channel, *this);
      if (kept) queue_.Push(kept, now_ns);
    }
    if (wanted.channel == TopicFeed::kTrial) hub_.tools().Return(*this, now_ns);
    if (wanted.channel == TopicFeed::kMouseState && mouse_state_) queue_.Push(mouse_state_, now_ns);
  }
}

std::string ViewerSession::OnBinary(std::span<const std::uint8_t> bytes) {
  const foxglove::ClientMessage message = foxglove::ParseMessage(bytes);
  const auto channel = published_.find(message.channel);
  if (channel == published_.end()) {
    return "a message on channel " + std::to_string(message.channel) +
           ", which it has not advertised";
  }
  try {
    (this->*channel->second)(message.payload);
  } catch (const Error& error) {
    Say(foxglove::Level::kWarning, error.what());
  }
  return "";
}

void ViewerSession::OnMouse(std::string_view payload) {
  const MouseCommand command = ParseMouseCommand(payload);
  MouseRoom& mice = hub_.tools().mice();
  const std::int64_t now_ns = SteadyNanoseconds();
  switch (command.op) {
    case MouseCommand::Op::kTake:
      return hub_.tools().Take(*this, command, now_ns);
    case MouseCommand::Op::kPose:
      return mice.Drag(id(), command.X_WT, command.still, now_ns);
    case MouseCommand::Op::kRelease:
      return mice.Release(id(), "", now_ns);
    case MouseCommand::Op::kWhole:
    case MouseCommand::Op::kBookmark:
    case MouseCommand::Op::kBack:
      return hub_.tools().Restore(*this, command, now_ns);
  }
}

void ViewerSession::OnReplay(std::string_view payload) {
  const std::int64_t now_ns = SteadyNanoseconds();
  queue_.Push(hub_.server().AskReplay(ParseReplayWish(payload), *this, now_ns),
              now_ns);  // OnRead flushes
}

void ViewerSession::OnOperate(std::string_view payload) {
  const OperateCommand command = ParseOperateCommand(payload);
  if (!hub_.viewers().Refuse(Wish::kOperate, *this, SteadyNanoseconds()).empty()) return;
  const std::string refusal = hub_.server().Operate(command, guest().Who());
  if (!refusal.empty()) Say(foxglove::Level::kError, std::string(kOperateTopic) + ": " + refusal);
}

void ViewerSession::OnClass(std::string_view payload) {
  const ClassCommand command = ParseClassCommand(payload);
  const std::int64_t now_ns = SteadyNanoseconds();
  if (!hub_.viewers().Refuse(Wish::kOperate, *this, now_ns).empty()) return;
  queue_.Push(hub_.course()->Teach(command, *this), now_ns);
}

void ViewerSession::OnExam(std::string_view payload) {
  const std::int64_t now_ns = SteadyNanoseconds();
  if (!hub_.viewers().Refuse(Wish::kOperate, *this, now_ns).empty()) return;
  queue_.Push(hub_.course()->Examine(payload, now_ns), now_ns);
}

void ViewerSession::OnTrial(std::string_view payload) {
  const std::string refusal =
      hub_.course()->Try(ParseTrialCommand(payload), *this, SteadyNanoseconds());
  if (!refusal.empty()) Say(foxglove::Level::kError, std::string(kTrialTopic) + ": " + refusal);
}

void ViewerSession::Watch(std::int64_t now_ns) {
  if (closing_ && now_ns - closing_ns_ > ViewerLimits::kFarewell_ns) return Gone();
  if (!open_ || !hub_.tools().mice().holds(id())) return;
  if (!signs_.Look(now_ns)) {
    return hub_.tools().Miss(id(), "the page sent nothing for 3 s", now_ns);
  }
  hub_.tools().mice().Return(id(), id(), now_ns);  // if it was silent
  if (pinging_ || !signs_.Ask()) return;
  pinging_ = true;
  socket_.async_ping({}, [self = shared_from_this()](beast::error_code) {
    self->pinging_ = false;  // a failure is seen when reading
  });
}

// --- sending ---

void ViewerSession::Say(foxglove::Level level, const std::string& message) {
  if (!complaints_.Pass(SteadyNanoseconds())) return;
  const std::uint64_t left_out = complaints_.TakeHeldBack();
  Send(foxglove::Status(level, left_out == 0 ? message
                                             : message + " (" + std::to_string(left_out) +
                                                   " more were left out before it)"));
}

void ViewerSession::TellMouseState(const FramePtr& frame) {
  mouse_state_ = frame;
  const std::int64_t now_ns = SteadyNanoseconds();
  queue_.Push(frame, now_ns);
  Flush(now_ns);
}

void ViewerSession::Send(std::string text) {
  if (closing_ || !open_) return;
  // A client that sends requests and does not read the answers is dropped.
  if (texts_.size() >= ViewerLimits::kMostTexts ||
      texts_size_ + text.size() > ViewerLimits::kMostTextBytes) {
    return Gone();
  }
  texts_size_ += text.size();
  texts_.push_back(std::move(text));
  Write();
}

void ViewerSession::Flush(std::int64_t now_ns) {
  if (!open_ || writing_ || closing_) return;
  if (texts_.empty()) {
    frame_ = queue_.Pop(now_ns);
    if (!frame_.frame) return;
  }
  Write();
}

void ViewerSession::Write() {
  if (!open_ || writing_) return;
  const auto written = [self = shared_from_this()](beast::error_code error, std::size_t) {
    self->OnWritten(error);
  };
  if (!texts_.empty()) {
    text_ = std::move(texts_.front());
    texts_.pop_front();
    texts_size_ -= text_.size();
    writing_ = true;
    socket_.text(true);
    socket_.async_write(net::buffer(text_), written);
  } else if (frame_.frame) {
    header_ = foxglove::MakeMessageHeader(frame_.subscription, frame_.frame->time_ns);
    writing_ = true;
    socket_.binary(true);
    socket_.async_write(
        std::array<net::const_buffer, 2>{net::buffer(header_), net::buffer(frame_.frame->payload)},
        written);
  } else if (closing_) {
    writing_ = true;
    socket_.async_close(close_reason_,
                        [self = shared_from_this()](beast::error_code) { self->Gone(); });
  }
}

void ViewerSession::OnWritten(beast::error_code error) {
  writing_ = false;
  if (error) return Gone();
  if (frame_.frame && text_.empty()) {
    ++frames_sent_;
    hub_.viewers().CountSent(frame_.frame->payload.size());
    frame_ = {};
  }
  text_.clear();
  if (closing_) return Write();
  Flush(SteadyNanoseconds());
}

void ViewerSession::Close(websocket::close_code code, const std::string& reason) {
  if (std::exchange(closing_, true)) return;
  if (!open_) return Gone();
  closing_ns_ = SteadyNanoseconds();
  close_reason_ = {code, reason};
  Write();
}

}  // namespace palpate
