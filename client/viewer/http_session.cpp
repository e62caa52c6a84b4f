#include "client/viewer/http_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "client/viewer/foxglove.h"
#include "client/viewer/viewer_session.h"
#include "common/metrics/metrics_page.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::uint32_t kLargestHeader = 8 * 1024;
constexpr std::chrono::seconds kPatience{15};  // for a request, and for a part of its answer
constexpr std::chrono::seconds kIdle{2};       // between an answer and the next request
/// An answer is given up if the client takes less than this on average [bytes/s].
constexpr std::uint64_t kLeastRate = 16 * 1024;
/// The page loads nothing from other hosts, and no page may frame it, so that no stolen click
/// takes a tool.  Inline styles: the plots and the page for a missing build.  WebAssembly:
/// the mesh coarsening.
constexpr const char* kContentPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' data:; "
    "style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";
/// Security headers of every answer: no type sniffing; no framing, opening or embedding by other
/// pages; no referrer, since an address may name a scene; no camera or other devices.
constexpr std::array<std::pair<const char*, const char*>, 7> kSafeHeaders = {{
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Content-Security-Policy", kContentPolicy},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Permissions-Policy",
     "camera=(), microphone=(), geolocation=(), usb=(), serial=(), hid=(), payment=()"},
}};
/// HSTS applies to every port of this name; a month and not a year, so that a host that drops its
/// certificate can be reached in the clear again before the next course.
constexpr const char* kOnlyTls = "max-age=2592000";
constexpr std::string_view kHealth = "/healthz";
constexpr std::string_view kMetrics = "/metrics";
constexpr std::string_view kScene = "/scene/";
constexpr std::string_view kBundle = ".bundle";
constexpr std::string_view kScore = "/score/";
constexpr std::string_view kExercise = "/exercise/";
constexpr std::string_view kHistory = "/history/";
/// A score page contains its scripts; nothing else may run there or be requested.
constexpr const char* kScorePolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "frame-ancestors 'none'; sandbox allow-scripts";

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

/// A strong ETag: it differs for each encoding, since it names the exact bytes.
std::string TagOf(std::uint64_t hash, bool gzip) {
  return fmt::format("\"{:016x}{}\"", hash, gzip ? "-gz" : "");
}

/// Returns the header in which a proxy names its client; the last line is the proxy's own.
std::string_view Forwarded(const http::fields& fields) {
  std::string_view last = View(fields[http::field::forwarded]);
  const auto [begin, end] = fields.equal_range("X-Forwarded-For");
  for (auto it = begin; it != end; ++it) last = View(it->value());
  return last;
}

std::uint64_t NextViewerId() {
  static std::uint64_t last = 0;
  return ++last;
}

std::span<const std::uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

HttpSession::HttpSession(boost::asio::ip::tcp::socket socket, HttpService& service)
    : stream_(std::move(socket)), service_(service), hub_(service.hub), lobby_(service.lobby) {}

HttpSession::~HttpSession() {
  if (place_) lobby_->Leave(*place_);
}

void HttpSession::Begin() {
  beast::error_code error;
  peer_ = stream_.next_layer().socket().remote_endpoint(error);
  if (error) return;  // it has gone
  visitor_ = VisitorAt(peer_, "", {});
  const auto close = [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->stream_.next_layer().close();
  };
  // A proxy forwards for many clients and must share its connections among them itself.
  const bool is_bounded = !visitor_.is_local && !IsProxy(peer_.address(), hub_.options().proxies);
  place_ = lobby_->Enter(is_bounded ? visitor_.address : "", close, SteadyNanoseconds());
  if (!place_) return;
  if (service_.tls != nullptr) return Secure();
  Read();
}

void HttpSession::Secure() {
  stream_.next_layer().expires_after(kPatience);
  const auto self = shared_from_this();
  beast::async_detect_ssl(stream_.next_layer(), input_,
                          [self](beast::error_code error, bool wants_tls) {
                            if (error) return self->stream_.next_layer().close();
                            if (!wants_tls) return self->Read();
                            self->stream_.AsyncSecure(*self->service_.tls, self->input_,
                                                      [self](beast::error_code result) {
                                                        if (result)
                                                          return self->stream_.next_layer().close();
                                                        self->Read();
                                                      });
                          });
}

void HttpSession::Read() {
  parser_.emplace();
  parser_->header_limit(kLargestHeader);
  parser_->body_limit(0);
  lobby_->Wait(*place_, SteadyNanoseconds());
  stream_.next_layer().expires_after(answered_ ? kIdle : kPatience);
  http::async_read_some(
      stream_, input_, *parser_,
      [self = shared_from_this()](beast::error_code error, std::size_t) { self->OnBegun(error); });
}

void HttpSession::OnBegun(beast::error_code error) {
  if (error || parser_->is_done()) return OnRead(error);
  stream_.next_layer().expires_after(kPatience);
  http::async_read(
      stream_, input_, *parser_,
      [self = shared_from_this()](beast::error_code result, std::size_t) { self->OnRead(result); });
}

void HttpSession::OnRead(beast::error_code error) {
  if (error == http::error::end_of_stream || error == beast::error::timeout) {
    stream_.next_layer().close();
    return;
  }
  lobby_->Serve(*place_);
  if (error) {
    if (error.category() != http::make_error_code(http::error::bad_method).category()) return;
    return Refuse(Request(), 400, Refusal::kRequest,
                  "this HTTP request is not supported: " + error.message());
  }
  Answer(parser_->get());
}

Asker HttpSession::AskerOf(const Request& request) const {
  Asker asker;
  asker.host = View(request[http::field::host]);
  asker.origin = View(request[http::field::origin]);
  asker.authorization = View(request[http::field::authorization]);
  asker.subprotocols = View(request[http::field::sec_websocket_protocol]);
  asker.hosts = static_cast<int>(request.count(http::field::host));
  asker.authorizations = static_cast<int>(request.count(http::field::authorization));
  asker.is_local = visitor_.is_local;
  asker.is_secure = stream_.is_secure();
  return asker;
}

void HttpSession::Refuse(const Request& request, int status, Refusal refusal,
                         const std::string& reason) {
  hub_.viewers().refusals().Say(refusal, visitor_.name, reason, SteadyNanoseconds());
  GiveText(request, static_cast<http::status>(status), reason + "\n");
}

void HttpSession::SendToTls(const Request& request) {
  // Its token was already sent in the clear, or it wants a WebSocket: it must get an error.
  const bool is_plain_get =
      (request.method() == http::verb::get || request.method() == http::verb::head) &&
      !beast::websocket::is_upgrade(request) && request.count(http::field::authorization) == 0 &&
      PathOfTarget(View(request.target()));
  if (!is_plain_get) {
    return Refuse(request, 400, Refusal::kTls,
                  "this port uses TLS: use https:// or wss://, and replace a token that was sent "
                  "unencrypted");
  }
  // Temporary: a port that drops its certificate must be found again.
  Response response{http::status::temporary_redirect, 11};
  response.set(http::field::location, "https://" + std::string(View(request[http::field::host])) +
                                          std::string(View(request.target())));
  last_ = true;  // its next request uses another connection
  Send(std::move(response), request);
}

void HttpSession::Answer(const Request& request) {
  visitor_ = VisitorAt(peer_, Forwarded(request), hub_.options().proxies);
  const Asker asker = AskerOf(request);
  if (const Verdict verdict = hub_.rights().gate().JudgeHost(asker);
      verdict.access == Access::kNone) {
    return Refuse(request, verdict.status, verdict.refusal, verdict.reason);
  }
  if (service_.tls != nullptr && !stream_.is_secure()) return SendToTls(request);
  if (beast::websocket::is_upgrade(request)) return Upgrade(request);
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Refuse(request, 405, Refusal::kRequest, "only GET and HEAD are supported");
  }
  const auto path = PathOfTarget(View(request.target()));
  if (!path) return Refuse(request, 400, Refusal::kRequest, "no path");
  // The page's own files are the same for everybody, and needed before a page can present a token.
  const bool is_of_page = *path != kHealth && *path != kMetrics && !path->starts_with(kScene) &&
                          !path->starts_with(kHistory);
  const Verdict verdict = hub_.rights().gate().JudgeToken(asker);
  if (!is_of_page && verdict.access == Access::kNone) {
    return Refuse(request, verdict.status, verdict.refusal, verdict.reason);
  }
  if (*path == kHealth) {
    last_ = true;  // every page asks every few seconds: none should hold a connection for that
    return GiveText(request, http::status::ok,
                    HealthOf(hub_.viewers(), hub_.feed(), hub_.tools().mice()), "application/json");
  }
  if (*path == kMetrics) {
    return GiveText(request, http::status::ok,
                    MetricsOf(hub_.viewers(), hub_.feed(), hub_.tools().mice()),
                    kMetricsContentType);
  }
  if (path->starts_with(kScene) && path->ends_with(kBundle) &&
      path->size() > kScene.size() + kBundle.size()) {
    return GiveScene(request,
                     path->substr(kScene.size(), path->size() - kScene.size() - kBundle.size()));
  }
  if (path->starts_with(kHistory)) {
    return GiveHistory(request, path->substr(kHistory.size()), verdict);
  }
  // Authorised by a key, told only to its person and to teachers: the link opens in a new tab,
  // which has no token.
  if (path->starts_with(kScore)) {
    return GiveOfCourse(request, &ExercisePages::PageOf, path->substr(kScore.size()));
  }
  if (path->starts_with(kExercise)) {
    return GiveOfCourse(request, &ExercisePages::PictureOf, path->substr(kExercise.size()));
  }
  GiveFile(request, *path);
}

void HttpSession::GiveOfCourse(const Request& request,
                               std::string (ExercisePages::*find)(const std::string&) const,
                               const std::string& name) {
  CourseDesk* const course = hub_.course();
  const std::string path = course != nullptr ? (course->trials().pages().*find)(name) : "";
  PageFile file{path, ContentTypeOf(path)};
  file.below = find == &ExercisePages::PageOf ? hub_.options().course
                                              : std::filesystem::path(path).parent_path().string();
  const auto content = path.empty() ? nullptr : service_.page.Read(file);
  if (!content) return GiveText(request, http::status::not_found, "there is no such file\n");
  Response response = ResponseOf(http::status::ok, "no-store");
  response.set(http::field::content_type, file.content_type);
  if (find == &ExercisePages::PageOf) response.set("Content-Security-Policy", kScorePolicy);
  Send(std::move(response), request, BytesOf(*content), content);
}

struct HttpSession::Rest {
  Rest(int of, std::uint64_t bytes, std::shared_ptr<const void> held)
      : file(of), left(bytes), given(std::move(held)) {}
  ~Rest() { close(file); }
  Rest(const Rest&) = delete;
  Rest& operator=(const Rest&) = delete;

  const int file;
  std::uint64_t left;
  const std::shared_ptr<const void> given;  // HistoryDesk::Answer
  std::vector<std::uint8_t> piece = std::vector<std::uint8_t>(std::size_t{1} << 18);
  /// Returns the next piece; empty: the file cannot be read.
  std::span<const std::uint8_t> Next() {
    const ssize_t count = read(file, piece.data(), std::min<std::uint64_t>(piece.size(), left));
    if (count <= 0) return {};
    left -= static_cast<std::uint64_t>(count);
    return {piece.data(), static_cast<std::size_t>(count)};
  }
};

void HttpSession::GiveHistory(const Request& request, const std::string& name,
                              const Verdict& verdict) {
  const auto wish = ParseHistoryWish(name);
  if (!wish) return GiveText(request, http::status::not_found, "there is no such history\n");
  if (!MayRead(*wish, verdict.access, verdict.holder ? verdict.holder->person : 0)) {
    return Refuse(request, 403, Refusal::kRole, "only teachers may read the results of others");
  }
  CourseDesk* const course = hub_.course();
  if (course == nullptr) {
    return GiveText(request, http::status::not_found, "there is no course here\n");
  }
  const std::string why = course->WhyNotInExam(verdict.holder ? verdict.holder->person : 0);
  if (!why.empty()) return Refuse(request, 403, Refusal::kRole, why);
  stream_.next_layer().expires_never();
  course->AskHistory(
      *wish, verdict.access == Access::kOperate,
      [self = shared_from_this(), request](HistoryDesk::Answer answer) {
        Response response = ResponseOf(static_cast<http::status>(answer.status), "no-store");
        response.set(http::field::content_type, answer.type);
        if (answer.file < 0) {
          const auto text = std::make_shared<const std::string>(std::move(answer.text));
          return self->Send(std::move(response), request, BytesOf(*text), text);
        }
        struct stat about {};
        fstat(answer.file, &about);
        const auto rest = std::make_shared<Rest>(
            answer.file, static_cast<std::uint64_t>(about.st_size), answer.given);
        self->Send(std::move(response), request, rest->Next(), rest, rest);
      });
}

void HttpSession::Upgrade(const Request& request) {
  const Verdict verdict = hub_.rights().gate().JudgeSocket(AskerOf(request));
  if (verdict.access == Access::kNone)
    return Refuse(request, verdict.status, verdict.refusal, verdict.reason);
  const std::string_view subprotocol =
      foxglove::ChooseSubprotocol(View(request[http::field::sec_websocket_protocol]));
  if (subprotocol.empty()) {
    return Refuse(request, 400, Refusal::kRequest,
                  "offer the subprotocol foxglove.websocket.v1 or foxglove.sdk.v1");
  }
  if (!hub_.viewers().MakeRoom(visitor_.address)) {
    return Refuse(request, 503, Refusal::kFull,
                  "this gateway has the maximum number of viewers (--max-viewers), and no address "
                  "has more of them than this one");
  }
  auto viewer =
      std::make_shared<ViewerSession>(std::move(stream_), hub_, NextViewerId(), visitor_, verdict);
  hub_.Join(viewer);
  viewer->Accept(request, subprotocol);
}

void HttpSession::Send(Response response, const Request& request,
                       std::span<const std::uint8_t> bytes, std::shared_ptr<const void> owner,
                       std::shared_ptr<Rest> rest) {
  const std::uint64_t all = bytes.size() + (rest ? rest->left : 0);
  const auto fill = [](Response::body_type::value_type& body, std::span<const std::uint8_t> next,
                       bool more) {
    body.data = next.empty() ? nullptr : const_cast<std::uint8_t*>(next.data());
    body.size = next.size();
    body.more = more;
  };
  fill(response.body(), bytes, all > bytes.size());
  if (response.result() != http::status::not_modified) response.content_length(all);
  response.set(http::field::server, "palpate-viewer/" PALPATE_VERSION);
  for (const auto& [name, value] : kSafeHeaders) {
    if (response.count(name) == 0) response.set(name, value);
  }
  if (stream_.is_secure()) response.set("Strict-Transport-Security", kOnlyTls);
  if (response.result() == http::status::unauthorized) {
    response.set(http::field::www_authenticate, "Bearer realm=\"palpate\"");
  }
  response.keep_alive(request.version() >= 11 && request.keep_alive() && !last_ &&
                      response.result_int() < 400);
  answered_ = true;
  // In pieces: a large scene on a slow line may take longer than the time limit of one piece.
  const auto end =
      std::chrono::steady_clock::now() + kPatience + std::chrono::seconds(all / kLeastRate);
  struct Sending {
    explicit Sending(Response of) : response(std::move(of)) {}
    Response response;
    http::response_serializer<Response::body_type> serializer{response};
    std::function<void(beast::error_code, std::size_t)> step;
  };
  const auto sending = std::make_shared<Sending>(std::move(response));
  const bool is_head = request.method() == http::verb::head;
  sending->serializer.split(is_head);
  sending->step = [self = shared_from_this(), owner, rest, fill, end, is_head,
                   weak = std::weak_ptr(sending)](beast::error_code error, std::size_t) {
    const auto its = weak.lock();
    if (error == http::error::need_buffer && rest) {
      const std::span<const std::uint8_t> next = rest->Next();
      if (next.empty()) return self->stream_.next_layer().close();
      fill(its->response.body(), next, rest->left > 0);
      error = {};
    }
    if (!error && !its->serializer.is_done() && !(is_head && its->serializer.is_header_done())) {
      self->stream_.next_layer().expires_at(
          std::min(end, std::chrono::steady_clock::now() + kPatience));
      return http::async_write_some(self->stream_, its->serializer,
                                    [its](beast::error_code e, std::size_t n) { its->step(e, n); });
    }
    if (!error && !its->response.need_eof()) return self->Read();
    beast::error_code ignored;
    self->stream_.next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send,
                                                 ignored);
  };
  sending->step({}, 0);
}

HttpSession::Response HttpSession::ResponseOf(http::status status, const char* cache) {
  Response response{status, 11};
  response.set(http::field::cache_control, cache);
  return response;
}

HttpSession::Response HttpSession::SceneResponse(http::status status, const std::string& etag) {
  Response response = ResponseOf(status, "no-cache");
  response.set(http::field::etag, etag);
  response.set(http::field::vary, "Accept-Encoding");
  return response;
}

void HttpSession::GiveText(const Request& request, http::status status, std::string text,
                           const char* type) {
  Response response = ResponseOf(status, "no-store");
  response.set(http::field::content_type, type);
  const auto kept = std::make_shared<const std::string>(std::move(text));
  Send(std::move(response), request, BytesOf(*kept), kept);
}

void HttpSession::GiveFile(const Request& request, const std::string& path) {
  const bool gzip = AcceptsGzip(View(request[http::field::accept_encoding]));
  const auto file = service_.page.Find(path, gzip);
  if (!file) {
    if (path == "/" || path == "/index.html") {
      return GiveText(request, http::status::ok, PageIsNotBuilt(hub_.options().page),
                      "text/html; charset=utf-8");
    }
    return GiveText(request, http::status::not_found, "there is no such file\n");
  }
  const std::shared_ptr<const std::string> content = service_.page.Read(*file);
  if (!content) return GiveText(request, http::status::not_found, "the file cannot be read\n");
  Response response = ResponseOf(http::status::ok,
                                 file->hashed ? "public, max-age=31536000, immutable" : "no-cache");
  response.set(http::field::content_type, file->content_type);
  response.set(http::field::vary, "Accept-Encoding");
  if (file->gzip) response.set(http::field::content_encoding, "gzip");
  Send(std::move(response), request, BytesOf(*content), content);
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
    return Send(SceneResponse(http::status::not_modified, etag), request);
  }
  const auto give = [self = shared_from_this(), request, scene](const PackedScene::Bytes& packed) {
    Response response = SceneResponse(http::status::ok, TagOf(scene.hash, packed != nullptr));
    response.set(http::field::content_type, "application/octet-stream");
    if (!packed) return self->Send(std::move(response), request, scene.bundle, scene.frame);
    response.set(http::field::content_encoding, "gzip");
    self->Send(std::move(response), request, *packed, packed);
  };
  if (!gzip) return give(nullptr);
  stream_.next_layer().expires_never();
  service_.packer.Pack(scene, give);
}

}  // namespace palpate
