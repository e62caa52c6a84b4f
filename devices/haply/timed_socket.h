#pragma once

#include <cstddef>
#include <string>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/system/error_code.hpp>
#include <boost/system/system_error.hpp>

namespace palpate::haply {

/// A TCP connection as Beast's WebSocket wants it, whose calls wait at most for a given time, and
/// no longer than until a descriptor becomes readable: Asio's own blocking calls do neither.
class TimedSocket {
 public:
  using executor_type = boost::asio::io_context::executor_type;

  /// @param stop  descriptor; -1: none.
  TimedSocket(boost::asio::io_context& io, int stop) : io_(&io), stop_(stop) {}
  ~TimedSocket();
  TimedSocket(const TimedSocket&) = delete;
  TimedSocket& operator=(const TimedSocket&) = delete;

  /// Throws std::system_error.
  void Connect(const std::string& host, const std::string& port);
  void set_timeout_ms(int timeout_ms) { timeout_ms_ = timeout_ms; }
  executor_type get_executor() const { return io_->get_executor(); }

  template <class Buffers>
  std::size_t read_some(const Buffers& buffers, boost::system::error_code& error) {
    for (auto at = boost::asio::buffer_sequence_begin(buffers);
         at != boost::asio::buffer_sequence_end(buffers); ++at) {
      const boost::asio::mutable_buffer buffer = *at;
      if (buffer.size() > 0) return Receive(buffer.data(), buffer.size(), error);
    }
    error = {};
    return 0;
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers, boost::system::error_code& error) {
    for (auto at = boost::asio::buffer_sequence_begin(buffers);
         at != boost::asio::buffer_sequence_end(buffers); ++at) {
      const boost::asio::const_buffer buffer = *at;
      if (buffer.size() > 0) return Transmit(buffer.data(), buffer.size(), error);
    }
    error = {};
    return 0;
  }
  template <class Buffers>
  std::size_t read_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t bytes = read_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return bytes;
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t bytes = write_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return bytes;
  }

 private:
  bool Ready(short events, boost::system::error_code& error) const;
  std::size_t Receive(void* data, std::size_t size, boost::system::error_code& error);
  std::size_t Transmit(const void* data, std::size_t size, boost::system::error_code& error);

  boost::asio::io_context* io_;
  int stop_;
  int fd_ = -1;
  int timeout_ms_ = 2000;
};

/// Beast's hook to end a connection: the destructor closes it.
inline void teardown(boost::beast::role_type, TimedSocket&, boost::system::error_code& error) {
  error = {};
}

}  // namespace palpate::haply
