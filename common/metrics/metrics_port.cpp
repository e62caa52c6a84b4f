#include "common/metrics/metrics_port.h"

#include <chrono>
#include <exception>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/http/host_name.h"
#include "common/http/lobby.h"
#include "common/realtime/rate_limit.h"
#include "common/realtime/steady_clock.h"
#include "common/text/number_of.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using net::ip::tcp;

/// Limit on connections.  Prometheus asks from one host every few seconds; people may look at the
/// same time.
constexpr std::size_t kConnections = 32;
constexpr std::uint32_t kLargestHeader = 8 * 1024;
/// Time limit for a whole request, and then for its whole answer.
constexpr std::chrono::seconds kPatience{5};
constexpr std::chrono::milliseconds kRetry{100};
constexpr std::string_view kPath = "/metrics";

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

std::string InUrl(const tcp::endpoint& endpoint) {
  std::ostringstream text;
  text << endpoint;  // an address of IPv6 in brackets
  return text.str();
}

}  // namespace

MetricsEndpoint ParseMetricsEndpoint(const std::string& text) {
  const auto refuse = [&](const std::string& why) {
    throw UsageError("--metrics " + Quoted(text) + ": " + why +
                     "; give one as 9464, 10.0.0.1:9464 or [::1]:9464");
  };
  MetricsEndpoint endpoint;
  const std::size_t colon = text.rfind(':');
  const auto port = NumberOf<std::uint16_t>(
      colon == std::string::npos ? text : std::string_view(text).substr(colon + 1));
  if (!port) refuse("is no [ADDRESS:]PORT");
  endpoint.port = *port;
  if (colon == std::string::npos) return endpoint;
  std::string address = text.substr(0, colon);
  const bool in_brackets = address.starts_with('[') && address.ends_with(']');
  if (in_brackets) address = address.substr(1, address.size() - 2);
  boost::system::error_code none;
  const net::ip::address parsed = net::ip::make_address(address, none);
  if (none) refuse("its ADDRESS is not an IP address");
  if (parsed.is_v6() != in_brackets) refuse("an address of IPv6, and no other, has brackets");
  endpoint.address = parsed.to_string();
  return endpoint;
}

/// The state shared by all connections.  Thread contract: the owner makes and destroys it; all else
/// runs in the service's thread.
class MetricsPort::Service {
 public:
  Service(Options options, std::function<void(MetricsPage&)> fill)
      : options_(std::move(options)),
        fill_(std::move(fill)),
        lobby_(kConnections, kConnections / 2),
        acceptor_(io_),
        retry_(io_) {
    Listen();
  }
  ~Service() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }
  void Start() {
    Accept();
    thread_ = std::thread([this] {
      pthread_setname_np(pthread_self(), "metrics");
      io_.run();
    });
  }

  const Options& options() const { return options_; }
  Lobby& lobby() { return lobby_; }
  /// Throws what the fill function throws.
  std::string Page() const {
    MetricsPage page;
    fill_(page);
    return page.ToText();
  }
  void TellRefusal(const std::string& who, const std::string& reason) {
    if (!refusals_.Pass(SteadyNanoseconds())) return;
    const std::uint64_t before = refusals_.TakeHeldBack();
    const std::string more =
        before > 0 ? " (" + std::to_string(before) + " more before it)" : std::string();
    spdlog::warn("metrics: refused {}: {}{}", who, reason, more);
  }

 private:
  void Listen();
  void Accept();

  const Options options_;
  const std::function<void(MetricsPage&)> fill_;
  RateLimit refusals_;
  // The lobby must outlive the connections, which handlers of the io_context hold and which leave
  // it when they end.
  Lobby lobby_;
  net::io_context io_{1};
  tcp::acceptor acceptor_;
  net::steady_timer retry_;
  std::thread thread_;
};

/// One request and its answer.
class MetricsPort::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Service& service)
      : stream_(std::move(socket)), service_(service), input_(2 * kLargestHeader) {}
  ~Connection() {
    if (place_) service_.lobby().Leave(*place_);
  }

  void Begin() {
    beast::error_code error;
    const tcp::endpoint peer = stream_.socket().remote_endpoint(error);
    if (error) return;  // the client has left
    who_ = InUrl(peer);
    const auto close = [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->stream_.close();
    };
    const bool is_local = peer.address().is_loopback();
    place_ = service_.lobby().Enter(is_local ? "" : peer.address().to_string(), close,
                                    SteadyNanoseconds());
    if (!place_) return service_.TellRefusal(who_, "there are as many connections as are taken");
    parser_.header_limit(kLargestHeader);
    parser_.body_limit(0);
    stream_.expires_after(kPatience);  // for the whole request: sending slowly gains no time
    http::async_read(stream_, input_, parser_,
                     [self = shared_from_this()](beast::error_code result, std::size_t) {
                       self->OnRead(result);
                     });
  }

 private:
  void OnRead(beast::error_code error) {
    if (error == http::error::end_of_stream || error == beast::error::timeout) return;
    if (error) {
      if (error.category() != http::make_error_code(http::error::bad_method).category()) return;
      return Refuse(http::status::bad_request,
                    "this HTTP request is not supported: " + error.message());
    }
    const auto& request = parser_.get();
    const auto& options = service_.options();
    if (const auto refusal =
            RefuseHost(static_cast<int>(request.count(http::field::host)),
                       View(request[http::field::host]), options.host_names, options.program)) {
      return Refuse(static_cast<http::status>(refusal->status), refusal->reason);
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      return Refuse(http::status::method_not_allowed, "only GET and HEAD are supported");
    }
    const std::string_view target = View(request.target());
    if (target.substr(0, target.find('?')) != kPath) {
      return Answer(http::status::not_found, "metrics are at /metrics\n");
    }
    std::string page;
    try {
      page = service_.Page();
    } catch (const std::exception& failure) {
      return Refuse(http::status::internal_server_error,
                    std::string("the page cannot be made: ") + failure.what());
    }
    Answer(http::status::ok, std::move(page), kMetricsContentType);
  }

  void Refuse(http::status status, const std::string& reason) {
    service_.TellRefusal(who_, reason);
    Answer(status, reason + "\n");
  }

  void Answer(http::status status, std::string text,
              const char* type = "text/plain; charset=utf-8") {
    answer_.version(11);
    answer_.result(status);
    answer_.set(http::field::server, "palpate/" PALPATE_VERSION);
    answer_.set(http::field::content_type, type);
    answer_.set(http::field::cache_control, "no-store");
    answer_.set("X-Content-Type-Options", "nosniff");
    answer_.set("Cross-Origin-Resource-Policy", "same-origin");
    answer_.body() = std::move(text);
    answer_.keep_alive(false);
    answer_.prepare_payload();
    if (parser_.get().method() == http::verb::head)
      answer_.body().clear();  // its length
                               // header remains
    service_.lobby().Serve(*place_);
    stream_.expires_after(kPatience);
    http::async_write(stream_, answer_,
                      [self = shared_from_this()](beast::error_code, std::size_t) {
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                      });
  }

  beast::tcp_stream stream_;
  Service& service_;
  std::string who_;
  std::optional<Lobby::Id> place_;
  beast::flat_buffer input_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> answer_;
};

void MetricsPort::Service::Listen() {
  const MetricsEndpoint& wanted = options_.endpoint;
  boost::system::error_code error;
  const net::ip::address address = net::ip::make_address(wanted.address, error);
  const tcp::endpoint at(address, static_cast<unsigned short>(wanted.port));
  if (!error) acceptor_.open(at.protocol(), error);
  if (!error) acceptor_.set_option(net::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(at, error);
  if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
  if (error) {
    throw Error(
        "--metrics " + InUrl(at) + ": cannot listen there (" + error.message() +
        "); give another port or address, if the port is taken or the address is not this host's");
  }
}

void MetricsPort::Service::Accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == net::error::operation_aborted) return;
    if (error) {
      // For example out of file descriptors, of which others will close some.
      retry_.expires_after(kRetry);
      retry_.async_wait([this](boost::system::error_code stopped) {
        if (!stopped) Accept();
      });
      return;
    }
    std::make_shared<Connection>(std::move(socket), *this)->Begin();
    Accept();
  });
}

MetricsPort::MetricsPort(Options options, std::function<void(MetricsPage&)> fill)
    : service_(std::make_unique<Service>(std::move(options), std::move(fill))),
      url_("http://" + InUrl(service_->endpoint()) + std::string(kPath)) {
  service_->Start();
}

MetricsPort::~MetricsPort() = default;

}  // namespace palpate
