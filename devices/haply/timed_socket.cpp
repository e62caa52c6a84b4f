#include "devices/haply/timed_socket.h"

#include <cerrno>
#include <memory>
#include <system_error>

#include <boost/asio/error.hpp>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate::haply {
namespace {

boost::system::error_code Errno() {
  return {errno, boost::system::system_category()};
}

}  // namespace

TimedSocket::~TimedSocket() {
  if (fd_ >= 0) close(fd_);
}

void TimedSocket::Connect(const std::string& host, const std::string& port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) {
    throw std::system_error(EHOSTUNREACH, std::generic_category(), "no such host");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  int why = ECONNREFUSED;
  // localhost is two addresses: the service may listen at either.
  for (const addrinfo* address = found; address; address = address->ai_next) {
    if (fd_ >= 0) close(fd_);
    fd_ = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd_ < 0) continue;
    if (connect(fd_, address->ai_addr, address->ai_addrlen) != 0 && errno != EINPROGRESS) {
      why = errno;
      continue;
    }
    boost::system::error_code error;
    int result = ETIMEDOUT;
    socklen_t size = sizeof result;
    if (Ready(POLLOUT, error)) getsockopt(fd_, SOL_SOCKET, SO_ERROR, &result, &size);
    if (result == 0) {
      const int on = 1;
      setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // a message is not held back
      return;
    }
    why = result;
  }
  throw std::system_error(why, std::generic_category());
}

bool TimedSocket::Ready(short events, boost::system::error_code& error) const {
  pollfd wait[2] = {{fd_, events, 0}, {stop_, POLLIN, 0}};
  const int ready = poll(wait, 2, timeout_ms_);
  if (ready > 0 && wait[1].revents == 0) return true;
  error = ready == 0 ? boost::asio::error::timed_out : boost::asio::error::operation_aborted;
  return false;
}

std::size_t TimedSocket::Receive(void* data, std::size_t size, boost::system::error_code& error) {
  for (;;) {
    const ssize_t bytes = recv(fd_, data, size, MSG_DONTWAIT);
    if (bytes > 0) {
      error = {};
      return static_cast<std::size_t>(bytes);
    }
    if (bytes == 0) {
      error = boost::asio::error::eof;
      return 0;
    }
    if (errno != EAGAIN && errno != EINTR) {
      error = Errno();
      return 0;
    }
    if (!Ready(POLLIN, error)) return 0;
  }
}

std::size_t TimedSocket::Transmit(const void* data, std::size_t size,
                                  boost::system::error_code& error) {
  for (;;) {
    const ssize_t bytes = send(fd_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (bytes >= 0) {
      error = {};
      return static_cast<std::size_t>(bytes);
    }
    if (errno != EAGAIN && errno != EINTR) {
      error = Errno();
      return 0;
    }
    if (!Ready(POLLOUT, error)) return 0;
  }
}

}  // namespace palpate::haply
