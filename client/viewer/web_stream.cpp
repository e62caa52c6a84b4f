#include "client/viewer/web_stream.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>

#include <boost/asio/ssl/impl/src.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/ssl.h>

#include "common/error.h"
#include "common/files/private_file.h"
#include "common/files/whole_file.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/token_bucket.h"

namespace palpate {

namespace beast = boost::beast;
namespace net = boost::asio;

net::ssl::context MakeTls(const std::string& certificate, const std::string& key) {
  namespace ssl = net::ssl;
  // Largest certificate chain or key file; they have some kB, including leading remarks.
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;
  // Read here and not by OpenSSL, so that the checked file is the one that is used.
  const std::string chain = ReadWholeFile(certificate, kMostBytes, "--tls-cert");
  std::string key_text = ReadWholeFile(key, kMostBytes, "--tls-key", IsPrivate("--tls-key", key));
  ssl::context context(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
  // Of TLS 1.2 only suites that encrypt and authenticate in one, with keys that are forgotten;
  // those of TLS 1.3 all do.
  SSL_CTX_set_cipher_list(context.native_handle(), "ECDHE+AESGCM:ECDHE+CHACHA20");
  // Repeated renegotiation by a client is expensive and unnecessary.
  SSL_CTX_set_options(context.native_handle(), SSL_OP_NO_RENEGOTIATION);
  beast::error_code error;
  context.use_certificate_chain(net::buffer(chain), error);
  if (error) {
    throw Error(
        fmt::format("--tls-cert {}: {}; give the server's certificate and those between it "
                    "and its root, as PEM",
                    certificate, error.message()));
  }
  // A service has no terminal to ask for a password, and a program with one would block.
  context.set_password_callback(
      [](std::size_t, ssl::context::password_purpose) { return std::string(); });
  context.use_private_key(net::buffer(key_text), ssl::context::pem, error);
  OPENSSL_cleanse(key_text.data(), key_text.size());
  if (error) {
    throw Error(
        fmt::format("--tls-key {}: {}; give the certificate's own key, as PEM and without "
                    "a password",
                    key, error.message()));
  }
  return context;
}

using Plain = beast::tcp_stream;
using Secure = beast::ssl_stream<beast::tcp_stream>;

struct WebStream::State {
  /// The limit of reading, and the timer of a reader that must wait.
  struct Rate {
    TokenBucket bytes;
    net::steady_timer rest;
  };

  std::variant<Plain, Secure> stream;
  std::optional<Rate> rate = std::nullopt;

  /// Calls `use` with the stream, plain or TLS.
  template <class Use>
  void With(Use use) {
    std::visit([&](auto& there) { use(there); }, stream);
  }
};

WebStream::WebStream(net::ip::tcp::socket socket)
    : state_(std::make_unique<State>(State{Plain(std::move(socket))})) {}
WebStream::WebStream(WebStream&& other) noexcept = default;
WebStream& WebStream::operator=(WebStream&& other) noexcept = default;
WebStream::~WebStream() = default;

beast::tcp_stream& WebStream::next_layer() noexcept {
  if (auto* const secure = std::get_if<Secure>(&state_->stream)) return secure->next_layer();
  return *std::get_if<Plain>(&state_->stream);
}
const beast::tcp_stream& WebStream::next_layer() const noexcept {
  return const_cast<WebStream*>(this)->next_layer();
}

bool WebStream::is_secure() const noexcept {
  return std::holds_alternative<Secure>(state_->stream);
}

void WebStream::AsyncSecure(net::ssl::context& context, beast::flat_buffer& read,
                            std::function<void(beast::error_code)> done) {
  Plain plain = std::move(std::get<Plain>(state_->stream));
  Secure& secure = state_->stream.emplace<Secure>(std::move(plain), context);
  secure.async_handshake(net::ssl::stream_base::server, read.data(),
                         [&read, done = std::move(done)](beast::error_code error, std::size_t n) {
                           read.consume(n);
                           done(error);
                         });
}

void WebStream::Read(std::vector<net::mutable_buffer> buffers, Done done) {
  // The reader's handler keeps the reader alive, which holds this stream.
  auto begin = [state = state_.get(), buffers = std::move(buffers),
                done = std::move(done)]() mutable {
    if (state->rate) {
      done = [state, done = std::move(done)](beast::error_code error, std::size_t n) {
        state->rate->bytes.Spend(static_cast<double>(n), SteadyNanoseconds());
        done(error, n);
      };
    }
    state->With([&](auto& stream) { stream.async_read_some(buffers, std::move(done)); });
  };
  const std::int64_t wait_ns =
      state_->rate ? state_->rate->bytes.WaitFor(1.0, SteadyNanoseconds()) : 0;
  if (wait_ns == 0) return begin();
  state_->rate->rest.expires_after(std::chrono::nanoseconds(wait_ns));
  state_->rate->rest.async_wait([begin](beast::error_code) mutable { begin(); });
}

void WebStream::LimitReading(double bytes_per_second, double at_once) {
  state_->rate =
      State::Rate{TokenBucket(bytes_per_second, at_once), net::steady_timer(get_executor())};
}

void WebStream::Write(std::vector<net::const_buffer> buffers, Done done) {
  state_->With([&](auto& stream) { stream.async_write_some(buffers, std::move(done)); });
}

void WebStream::TearDown(beast::role_type role, Done done) {
  state_->With([&](auto& stream) {
    using beast::websocket::async_teardown;
    async_teardown(role, stream,
                   [done = std::move(done)](beast::error_code error) { done(error, 0); });
  });
}

}  // namespace palpate
