#include "client/load/web_viewers.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "common/dds/cdr.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace net = boost::asio;
namespace websocket = beast::websocket;
using Json = nlohmann::ordered_json;
using net::ip::tcp;

constexpr const char* kTopic = "/palpate/tool_state";
constexpr std::uint32_t kSubscription = 1;
/// Bytes of a message's opcode, subscription and time, before its payload.
constexpr std::size_t kHeader = 13;
constexpr std::uint8_t kMessageData = 1;
/// Viewers that connect at the same time: a gateway has few places for clients that have not
/// yet subscribed.
constexpr std::size_t kAtOnce = 32;

/// Raises the limit of open files: one per socket, and some for DDS and files.
void AllowFiles(std::size_t sockets) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t wanted = sockets + 512;
  if (limit.rlim_cur >= wanted) return;
  if (limit.rlim_max < wanted) {
    throw Error(std::to_string(sockets) +
                " viewers need as many open files, but this user's limit is " +
                std::to_string(limit.rlim_max) + "; raise it with 'ulimit -Hn', or give fewer");
  }
  limit.rlim_cur = wanted;
  setrlimit(RLIMIT_NOFILE, &limit);
}

/// Why viewers could not connect.
enum class Trouble {
  kNobody,    ///< nothing listens at the address
  kStranger,  ///< the peer is not a gateway, or closes the connection
  kFull,      ///< the gateway accepts no more
};

struct Shared {
  Shared(FrameTally& to, const ViewerUrl& url)
      : tally(to), host_header(url.host + ":" + std::to_string(url.port)) {}

  FrameTally& tally;
  const std::string host_header;
  std::function<void()> start_next;  ///< starts the next viewer, in the event loop
  std::atomic<std::size_t> attached{0};
  std::atomic<std::size_t> gone{0};
  std::mutex mutex;
  std::optional<Trouble> trouble;  // the first; guarded by the mutex
  std::string complaint;           // its text; guarded by the mutex

  void Complain(Trouble what, const std::string& why) {
    const std::lock_guard lock(mutex);
    if (trouble) return;
    trouble = what;
    complaint = why;
  }
};

class Viewer {
 public:
  Viewer(net::io_context& io, Shared& shared, std::size_t index)
      : socket_(io), shared_(shared), index_(index) {}

  void Start(const tcp::endpoint& endpoint) {
    socket_.next_layer().async_connect(endpoint, [this](beast::error_code error) {
      if (error) return shared_.Complain(Trouble::kNobody, error.message());
      Shake();
    });
  }

 private:
  void Shake() {
    beast::error_code ignored;
    socket_.next_layer().set_option(tcp::no_delay(true), ignored);
    socket_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
      request.set(http::field::sec_websocket_protocol, "foxglove.websocket.v1");
    }));
    socket_.read_message_max(0);
    socket_.async_handshake(response_, shared_.host_header, "/", [this](beast::error_code error) {
      if (error == websocket::error::upgrade_declined) {
        const bool full = response_.result() == http::status::service_unavailable;
        return shared_.Complain(full ? Trouble::kFull : Trouble::kStranger,
                                "HTTP status " + std::to_string(response_.result_int()));
      }
      if (error) return shared_.Complain(Trouble::kStranger, error.message());
      Read();
    });
  }

  void Read() {
    socket_.async_read(buffer_, [this](beast::error_code error, std::size_t) {
      const std::int64_t now_ns = SteadyNanoseconds();
      if (error) return Gone(error);
      const std::span bytes(static_cast<const std::uint8_t*>(buffer_.cdata().data()),
                            buffer_.size());
      if (socket_.got_text()) {
        OnText({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      } else if (bytes.size() > kHeader && bytes[0] == kMessageData &&
                 dds::FromCdr(bytes.subspan(kHeader), frame_)) {
        shared_.tally.Add(index_, frame_, now_ns);
      }
      buffer_.clear();
      Read();
    });
  }

  void OnText(std::string_view text) {
    const Json message = Json::parse(text, nullptr, false);
    if (!message.is_object() || message.value("op", "") != "advertise") return;
    for (const Json& channel : message["channels"]) {
      if (channel.value("topic", "") == kTopic) return Subscribe(channel["id"]);
    }
    shared_.Complain(Trouble::kStranger, std::string("it has no channel ") + kTopic);
  }

  void Subscribe(std::uint32_t channel) {
    if (subscribing_) return;
    subscribing_ = true;
    request_ = Json{{"op", "subscribe"},
                    {"subscriptions", {{{"id", kSubscription}, {"channelId", channel}}}}}
                   .dump();
    socket_.text(true);
    socket_.async_write(net::buffer(request_), [this](beast::error_code error, std::size_t) {
      if (error) return Gone(error);
      attached_ = true;
      ++shared_.attached;
      shared_.start_next();
    });
  }

  void Gone(beast::error_code error) {
    if (attached_) {
      ++shared_.gone;
    } else {
      shared_.Complain(Trouble::kStranger, error.message());
    }
  }

  websocket::stream<tcp::socket, false> socket_;  // false: no compression
  Shared& shared_;
  std::size_t index_;
  bool subscribing_ = false;
  bool attached_ = false;
  websocket::response_type response_;
  beast::flat_buffer buffer_;
  std::string request_;
  wire::ToolState frame_{};
};

Error WhyNot(Trouble trouble, const ViewerUrl& url, const std::string& why) {
  const std::string start = "start 'palpate-viewer --http " + std::to_string(url.port) + "'";
  switch (trouble) {
    case Trouble::kFull:
      return Error("the gateway at " + url.text() + " refuses viewers (" + why +
                   "); start palpate-viewer with more --max-viewers, or give fewer");
    case Trouble::kStranger:
      return Error("the program at " + url.text() + " is not a palpate-viewer, or has ended (" +
                   why + "); " + start + " where the port is free, or give --viewer-url");
    default:
      return Error("no gateway answers at " + url.text() + " (" + why + "); " + start +
                   ", or give --viewer-url");
  }
}

}  // namespace

struct WebViewers::State {
  State(FrameTally& tally, const ViewerUrl& url) : shared(tally, url) {}

  net::io_context io{1};
  Shared shared;
  std::vector<std::unique_ptr<Viewer>> viewers;
  std::size_t started = 0;
  std::thread thread;

  ~State() {
    io.stop();
    if (thread.joinable()) thread.join();
  }
};

WebViewers::WebViewers(const ViewerUrl& url, std::size_t viewers, double wait_s, FrameTally& tally,
                       StopSignal& stop)
    : state_(std::make_unique<State>(tally, url)) {
  if (viewers == 0) return;
  AllowFiles(viewers);
  State& s = *state_;
  beast::error_code error;
  tcp::resolver resolver(s.io);
  const auto found = resolver.resolve(url.host, std::to_string(url.port), error);
  if (error) throw WhyNot(Trouble::kNobody, url, error.message());
  for (std::size_t i = 0; i < viewers; ++i) {
    s.viewers.push_back(std::make_unique<Viewer>(s.io, s.shared, i));
  }
  s.shared.start_next = [&s, endpoint = found.begin()->endpoint()] {
    if (s.started < s.viewers.size()) s.viewers[s.started++]->Start(endpoint);
  };
  for (std::size_t i = 0; i < kAtOnce; ++i) s.shared.start_next();
  s.thread = std::thread([&s] { s.io.run(); });

  const std::int64_t until_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * wait_s);
  while (s.shared.attached < viewers) {
    {
      const std::lock_guard lock(s.shared.mutex);
      if (s.shared.trouble) throw WhyNot(*s.shared.trouble, url, s.shared.complaint);
    }
    if (SteadyNanoseconds() > until_ns) {
      const std::size_t attached = s.shared.attached;
      if (attached == 0) throw WhyNot(Trouble::kNobody, url, "no word within --wait");
      throw Error("the gateway at " + url.text() + " has accepted " + std::to_string(attached) +
                  " of " + std::to_string(viewers) +
                  " viewers within --wait; give fewer, or a longer one");
    }
    if (stop.WaitFor(std::chrono::milliseconds(5))) return;
  }
}

WebViewers::~WebViewers() = default;

std::size_t WebViewers::gone() const {
  return state_->shared.gone;
}

}  // namespace palpate
