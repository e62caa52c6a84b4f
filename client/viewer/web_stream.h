#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace palpate {

/// Returns a context for TLS 1.2 and newer, from a certificate chain and its key, both PEM.  Throws
/// Error that names the flag and the file.
boost::asio::ssl::context MakeTls(const std::string& certificate, const std::string& key);

/// A connection of the gateway, plain or over TLS: an AsyncStream of Beast, and the only place that
/// knows which of the two it is.  Handlers and buffers are type-erased here, so HTTP and WebSockets
/// are compiled once, and TLS only in this class's source file.
/// Thread contract: the network thread.
class WebStream {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;
  using Done = std::function<void(boost::beast::error_code, std::size_t)>;

  explicit WebStream(boost::asio::ip::tcp::socket socket);
  WebStream(WebStream&& other) noexcept;
  WebStream& operator=(WebStream&& other) noexcept;
  ~WebStream();

  executor_type get_executor() noexcept { return next_layer().get_executor(); }
  /// The layer below TLS: the socket with its timeouts, Beast's lowest layer.
  next_layer_type& next_layer() noexcept;
  const next_layer_type& next_layer() const noexcept;
  bool is_secure() const noexcept;

  /// Switches to TLS; `done` is called after the handshake.
  /// @param context  must outlive the stream.
  /// @param read     what was already read in the clear, to detect TLS; is consumed, and must
  /// live until `done`.
  void AsyncSecure(boost::asio::ssl::context& context, boost::beast::flat_buffer& read,
                   std::function<void(boost::beast::error_code)> done);

  /// Limits the reading rate; what exceeds it waits in the network.
  void LimitReading(double bytes_per_second, double at_once);

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    Read({boost::asio::buffer_sequence_begin(buffers), boost::asio::buffer_sequence_end(buffers)},
         Shared(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    Write({boost::asio::buffer_sequence_begin(buffers), boost::asio::buffer_sequence_end(buffers)},
          Shared(std::forward<Handler>(handler)));
  }
  /// Called by Beast to end the connection below a WebSocket.
  template <class Handler>
  friend void async_teardown(boost::beast::role_type role, WebStream& stream, Handler&& handler) {
    stream.TearDown(role, Shared([handler = std::forward<Handler>(handler)](
                                     boost::beast::error_code error, std::size_t) mutable {
                      std::move(handler)(error);
                    }));
  }

 private:
  struct State;

  /// Makes a handler copyable: Beast's can only be moved.
  template <class Handler>
  static Done Shared(Handler&& handler) {
    auto shared = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return
        [shared](boost::beast::error_code error, std::size_t n) { std::move (*shared)(error, n); };
  }
  void Read(std::vector<boost::asio::mutable_buffer> buffers, Done done);
  void Write(std::vector<boost::asio::const_buffer> buffers, Done done);
  void TearDown(boost::beast::role_type role, Done done);

  std::unique_ptr<State> state_;
};

}  // namespace palpate
