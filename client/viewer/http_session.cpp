#include "client/viewer/http_session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "client/viewer/access.h"
#include "client/viewer/foxglove.h"
#include "client/viewer/quoted.h"
#include "client/viewer/viewer_session.h"
#include "common/metrics/metrics_page.h"
#include "common/time/steady_clock.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::uint32_t kLargestHeader = 8 * 1024;
constexpr std::chrono::seconds kPatience{15};  // for a request, and for a part of its answer
constexpr std::chrono::seconds kIdle{2};       // between an answer and the next request
/// An answer is given up where less of it is taken, on the whole [bytes/s].
constexpr std::uint64_t kLeastRate = 16 * 1024;
/// The page needs nothing from elsewhere, and nobody's page may hold it in a frame and have a click
/// take a tool.  Plots and the page that stands in for it set styles; what makes coarser meshes is
/// WebAssembly.
constexpr const char* kContentPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' data:; "
    "style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";
constexpr std::string_view kScene = "/scene/";
constexpr std::string_view kBundle = ".bundle";

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

/// Strong: it names the very bytes, so those of each encoding apart.
std::string TagOf(std::uint64_t hash, bool gzip) {
  return fmt::format("\"{:016x}{}\"", hash, gzip ? "-gz" : "");
}

std::uint64_t NextViewerId() {
  static std::uint64_t last = 0;
  return ++last;
}

}  // namespace

HttpSession::HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub,
                         std::shared_ptr<Lobby> lobby)
    : stream_(std::move(socket)), hub_(hub), lobby_(std::move(lobby)) {}

HttpSession::~HttpSession() {
  if (place_) lobby_->Leave(*place_);
}

void HttpSession::Begin() {
  beast::error_code error;
  const auto peer = stream_.socket().remote_endpoint(error).address();
  if (error) return;  // it has gone
  const auto close = [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->stream_.close();
  };
  place_ = lobby_->Enter(peer.is_loopback() ? "" : peer.to_string(), close, SteadyNanoseconds());
  if (place_) Read();
}

void HttpSession::Read() {
  parser_.emplace();
  parser_->header_limit(kLargestHeader);
  parser_->body_limit(0);
  lobby_->Wait(*place_, SteadyNanoseconds());
  stream_.expires_after(answered_ ? kIdle : kPatience);
  http::async_read_some(
      stream_, input_, *parser_,
      [self = shared_from_this()](beast::error_code error, std::size_t) { self->OnBegun(error); });
}

void HttpSession::OnBegun(beast::error_code error) {
  if (error || parser_->is_done()) return OnRead(error);
  stream_.expires_after(kPatience);
  http::async_read(
      stream_, input_, *parser_,
      [self = shared_from_this()](beast::error_code result, std::size_t) { self->OnRead(result); });
}

void HttpSession::OnRead(beast::error_code error) {
  if (error == http::error::end_of_stream || error == beast::error::timeout) {
    stream_.close();
    return;
  }
  lobby_->Serve(*place_);
  if (error) {
    const Request none;
    if (error.category() != http::make_error_code(http::error::bad_method).category()) return;
    return GiveText(none, http::status::bad_request,
                    "this is no HTTP request that is understood here: " + error.message() + "\n");
  }
  Answer(parser_->get());
}

void HttpSession::Answer(const Request& request) {
  if (beast::websocket::is_upgrade(request)) return Upgrade(request);
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return GiveText(request, http::status::method_not_allowed, "only GET and HEAD\n");
  }
  const auto path = PathOfTarget(View(request.target()));
  if (!path) return GiveText(request, http::status::bad_request, "no path\n");
  if (*path == "/healthz") {
    last_ = true;  // asked every few seconds by every page: none should hold a connection for that
    return GiveText(request, http::status::ok, hub_.Health(), "application/json");
  }
  if (*path == "/metrics") {
    return GiveText(request, http::status::ok, hub_.Metrics(), kMetricsContentType);
  }
  if (path->starts_with(kScene) && path->ends_with(kBundle) &&
      path->size() > kScene.size() + kBundle.size()) {
    return GiveScene(request,
                     path->substr(kScene.size(), path->size() - kScene.size() - kBundle.size()));
  }
  GiveFile(request, *path);
}

void HttpSession::Upgrade(const Request& request) {
  const std::string_view origin = View(request[http::field::origin]);
  const Access access = AccessOf(origin, View(request[http::field::host]),
                                 IsLoopback(hub_.options().address), hub_.options().origins);
  if (access == Access::kNone) {
    const std::string who = Quoted(origin);
    hub_.CountRefusal();
    spdlog::warn("a page of {} wanted to attach and was refused; --allow-origin lets it in", who);
    return GiveText(request, http::status::forbidden,
                    "a page from elsewhere may not attach: its Origin is " + who +
                        "; palpate-viewer --allow-origin lets it in\n");
  }
  const std::string_view subprotocol =
      foxglove::ChooseSubprotocol(View(request[http::field::sec_websocket_protocol]));
  if (subprotocol.empty()) {
    return GiveText(request, http::status::bad_request,
                    "offer the subprotocol foxglove.websocket.v1 or foxglove.sdk.v1\n");
  }
  if (hub_.full()) {
    hub_.CountRefusal();
    return GiveText(request, http::status::service_unavailable,
                    "there are as many viewers as this gateway takes (--max-viewers)\n");
  }
  auto viewer = std::make_shared<ViewerSession>(std::move(stream_), hub_, NextViewerId(),
                                                access == Access::kAll);
  hub_.Join(viewer);
  viewer->Accept(request, subprotocol);
}

template <class Body>
void HttpSession::Send(http::response<Body> response, const Request& request,
                       std::shared_ptr<const void> owner) {
  response.version(11);
  response.set(http::field::server, "palpate-viewer/" PALPATE_VERSION);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kContentPolicy);
  response.keep_alive(request.version() >= 11 && request.keep_alive() && !last_ &&
                      response.result_int() < 400);
  answered_ = true;
  stream_.expires_after(kPatience);
  const auto sent = [self = shared_from_this(), owner](const auto& message,
                                                       beast::error_code error) {
    if (error || message.need_eof()) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
      return;
    }
    self->Read();
  };
  if (request.method() == http::verb::head) {
    auto head = std::make_shared<http::response<http::empty_body>>(std::move(response.base()));
    http::async_write(stream_, *head,
                      [head, sent](beast::error_code error, std::size_t) { sent(*head, error); });
    return;
  }
  auto whole = std::make_shared<http::response<Body>>(std::move(response));
  // In pieces: a large scene over a slow line may take longer than the patience for one of them.
  const auto end = std::chrono::steady_clock::now() + kPatience +
                   std::chrono::seconds(whole->payload_size().value_or(0) / kLeastRate);
  auto serializer = std::make_shared<http::response_serializer<Body>>(*whole);
  const auto step = std::make_shared<std::function<void(beast::error_code, std::size_t)>>();
  *step = [self = shared_from_this(), whole, serializer, sent, end, weak = std::weak_ptr(step)](
              beast::error_code error, std::size_t) {
    if (error || serializer->is_done()) return sent(*whole, error);
    self->stream_.expires_at(std::min(end, std::chrono::steady_clock::now() + kPatience));
    http::async_write_some(
        self->stream_, *serializer,
        [next = weak.lock()](beast::error_code e, std::size_t n) { (*next)(e, n); });
  };
  (*step)({}, 0);
}

void HttpSession::GiveText(const Request& request, http::status status, std::string text,
                           const char* type) {
  http::response<http::string_body> response{status, 11};
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-store");
  response.body() = std::move(text);
  response.prepare_payload();
  Send(std::move(response), request);
}

void HttpSession::GiveFile(const Request& request, const std::string& path) {
  const bool gzip = AcceptsGzip(View(request[http::field::accept_encoding]));
  const auto file = hub_.page().Find(path, gzip);
  if (!file) {
    if (path == "/" || path == "/index.html") {
      return GiveText(request, http::status::ok, PageIsNotBuilt(hub_.options().page),
                      "text/html; charset=utf-8");
    }
    return GiveText(request, http::status::not_found, "there is no such file\n");
  }
  http::response<http::file_body> response{http::status::ok, 11};
  beast::error_code error;
  response.body().open(file->path.c_str(), beast::file_mode::scan, error);
  if (error) return GiveText(request, http::status::not_found, "the file cannot be read\n");
  response.set(http::field::content_type, file->content_type);
  response.set(http::field::vary, "Accept-Encoding");
  response.set(http::field::cache_control,
               file->hashed ? "public, max-age=31536000, immutable" : "no-cache");
  if (file->gzip) response.set(http::field::content_encoding, "gzip");
  response.prepare_payload();
  Send(std::move(response), request);
}

void HttpSession::GiveScene(const Request& request, const std::string& name) {
  const auto found = hub_.feed().scenes().find(name);
  if (found == hub_.feed().scenes().end()) {
    return GiveText(request, http::status::not_found,
                    "no server has given this gateway a scene of that name\n");
  }
  const SceneBytes scene = found->second;
  const bool gzip = AcceptsGzip(View(request[http::field::accept_encoding]));
  const std::string etag = TagOf(scene.hash, gzip);
  if (View(request[http::field::if_none_match]).find(etag) != std::string_view::npos) {
    http::response<http::empty_body> response{http::status::not_modified, 11};
    response.set(http::field::etag, etag);
    response.set(http::field::vary, "Accept-Encoding");
    response.set(http::field::cache_control, "no-cache");
    return Send(std::move(response), request);
  }
  if (!gzip) return GiveBytes(request, scene.frame, scene.bundle, scene.hash, false);
  stream_.expires_never();
  hub_.WithPacked(scene,
                  [self = shared_from_this(), request, scene](const ScenePacker::Bytes& packed) {
                    if (packed) {
                      self->GiveBytes(request, packed, *packed, scene.hash, true);
                    } else {
                      self->GiveBytes(request, scene.frame, scene.bundle, scene.hash, false);
                    }
                  });
}

void HttpSession::GiveBytes(const Request& request, std::shared_ptr<const void> owner,
                            std::span<const std::uint8_t> bytes, std::uint64_t hash, bool gzip) {
  http::response<http::span_body<const std::uint8_t>> response{http::status::ok, 11};
  response.body() = {bytes.data(), bytes.size()};
  response.set(http::field::content_type, "application/octet-stream");
  response.set(http::field::etag, TagOf(hash, gzip));
  response.set(http::field::vary, "Accept-Encoding");
  response.set(http::field::cache_control, "no-cache");
  if (gzip) response.set(http::field::content_encoding, "gzip");
  response.prepare_payload();
  Send(std::move(response), request, std::move(owner));
}

}  // namespace palpate
