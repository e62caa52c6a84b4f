#include "client/viewer/http_session.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "client/viewer/access.h"
#include "client/viewer/foxglove.h"
#include "client/viewer/viewer_session.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::uint32_t kLargestHeader = 8 * 1024;
constexpr std::chrono::seconds kPatience{15};  // for a request, and for its answer to be taken
constexpr std::string_view kScene = "/scene/";
constexpr std::string_view kBundle = ".bundle";

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

std::uint64_t NextViewerId() {
  static std::uint64_t last = 0;
  return ++last;
}

}  // namespace

HttpSession::HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub,
                         std::function<void()> on_end)
    : stream_(std::move(socket)), hub_(hub), on_end_(std::move(on_end)) {}

HttpSession::~HttpSession() {
  on_end_();
}

void HttpSession::Read() {
  parser_.emplace();
  parser_->header_limit(kLargestHeader);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(
      stream_, input_, *parser_,
      [self = shared_from_this()](beast::error_code error, std::size_t) { self->OnRead(error); });
}

void HttpSession::OnRead(beast::error_code error) {
  if (error == http::error::end_of_stream || error == beast::error::timeout) {
    stream_.close();
    return;
  }
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
    return GiveText(request, http::status::ok, hub_.Health(), "application/json");
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
  if (!MayAttach(origin, View(request[http::field::host]), IsLoopback(hub_.options().address),
                 hub_.options().origins)) {
    spdlog::warn("a page of {} wanted to attach and was refused; --allow-origin lets it", origin);
    return GiveText(request, http::status::forbidden,
                    "a page from elsewhere may not attach; see palpate-viewer --allow-origin\n");
  }
  const std::string_view subprotocol =
      foxglove::ChooseSubprotocol(View(request[http::field::sec_websocket_protocol]));
  if (subprotocol.empty()) {
    return GiveText(request, http::status::bad_request,
                    "offer the subprotocol foxglove.websocket.v1 or foxglove.sdk.v1\n");
  }
  if (hub_.full()) {
    return GiveText(request, http::status::service_unavailable,
                    "there are as many viewers as this gateway takes (--max-viewers)\n");
  }
  auto viewer = std::make_shared<ViewerSession>(std::move(stream_), hub_, NextViewerId());
  hub_.Join(viewer);
  viewer->Accept(request, subprotocol);
}

template <class Body>
void HttpSession::Send(http::response<Body> response, const Request& request,
                       std::shared_ptr<const void> owner) {
  response.version(11);
  response.set(http::field::server, "palpate-viewer/" PALPATE_VERSION);
  response.set("X-Content-Type-Options", "nosniff");
  response.keep_alive(request.version() >= 11 && request.keep_alive() &&
                      response.result_int() < 400);
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
  auto serializer = std::make_shared<http::response_serializer<Body>>(*whole);
  const auto step = std::make_shared<std::function<void(beast::error_code, std::size_t)>>();
  *step = [self = shared_from_this(), whole, serializer, sent, weak = std::weak_ptr(step)](
              beast::error_code error, std::size_t) {
    if (error || serializer->is_done()) return sent(*whole, error);
    self->stream_.expires_after(kPatience);
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
  const std::string etag = fmt::format("\"{:016x}\"", scene.hash);
  if (View(request[http::field::if_none_match]) == etag) {
    http::response<http::empty_body> response{http::status::not_modified, 11};
    response.set(http::field::etag, etag);
    return Send(std::move(response), request);
  }
  if (!AcceptsGzip(View(request[http::field::accept_encoding]))) {
    return GiveBytes(request, scene.frame, scene.bundle, etag, false);
  }
  stream_.expires_never();
  hub_.WithPacked(name,
                  [self = shared_from_this(), request, scene, etag](const Hub::Bytes& packed) {
                    if (packed) {
                      self->GiveBytes(request, packed, *packed, etag, true);
                    } else {
                      self->GiveBytes(request, scene.frame, scene.bundle, etag, false);
                    }
                  });
}

void HttpSession::GiveBytes(const Request& request, std::shared_ptr<const void> owner,
                            std::span<const std::uint8_t> bytes, const std::string& etag,
                            bool gzip) {
  http::response<http::span_body<const std::uint8_t>> response{http::status::ok, 11};
  response.body() = {bytes.data(), bytes.size()};
  response.set(http::field::content_type, "application/octet-stream");
  response.set(http::field::etag, etag);
  response.set(http::field::vary, "Accept-Encoding");
  response.set(http::field::cache_control, "no-cache");
  if (gzip) response.set(http::field::content_encoding, "gzip");
  response.prepare_payload();
  Send(std::move(response), request, std::move(owner));
}

}  // namespace palpate
