#include "client/igtl/igtl_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

/// Bytes read from one client between two sendings: more than any well-behaved client sends.
constexpr std::size_t kMostRead = 65'536;
/// New clients that are accepted between two sendings.
constexpr int kMostAccepted = 32;

bool WouldBlock(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

}  // namespace

IgtlServer::IgtlServer(const std::string& address, int port) {
  const std::string what = "--bind " + address + ", --port " + std::to_string(port);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &place.sin_addr) != 1) {
    throw UsageError(what + ": give an IP address such as 127.0.0.1 or 0.0.0.0");
  }
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  socklen_t size = sizeof place;
  auto* const generic = reinterpret_cast<sockaddr*>(&place);
  if (listener_ < 0 || setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(listener_, generic, size) != 0 || listen(listener_, kMostAccepted) != 0 ||
      getsockname(listener_, generic, &size) != 0) {
    const int error = errno;
    if (listener_ >= 0) close(listener_);
    throw Error(what + ": cannot listen there (" + std::strerror(error) + "); give another");
  }
  port_ = ntohs(place.sin_port);
}

IgtlServer::~IgtlServer() {
  for (const Client& client : clients_) close(client.socket);
  close(listener_);
}

void IgtlServer::Poll(std::int64_t now_ns) {
  for (int i = 0; i < kMostAccepted; ++i) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const int socket =
        accept4(listener_, reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) break;
    if (!MakeRoom(from.sin_addr.s_addr)) {
      close(socket);
      ++counts_.refused;
      continue;
    }
    const int yes = 1;
    setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    clients_.push_back({socket, from.sin_addr.s_addr, {}, now_ns, false});
  }
  std::array<std::uint8_t, 8192> ignored;
  for (Client& client : clients_) {
    for (std::size_t read = 0; read < kMostRead;) {
      const ssize_t n = recv(client.socket, ignored.data(), ignored.size(), 0);
      if (n > 0) {
        read += static_cast<std::size_t>(n);
        continue;
      }
      client.gone = n == 0 || !WouldBlock(errno);
      break;
    }
  }
  DropGone();
}

void IgtlServer::Send(std::span<const std::uint8_t> messages, std::int64_t now_ns) {
  for (Client& client : clients_) {
    if (!client.rest.empty()) {
      const std::vector<std::uint8_t> rest = std::move(client.rest);
      client.rest.clear();
      Write(client, rest, now_ns);
    }
    if (client.rest.empty()) {
      Write(client, messages, now_ns);
    } else {
      ++counts_.passed_over;
    }
    if (!client.gone && now_ns - client.took_ns > kPatience_ns) {
      client.gone = true;
      ++counts_.closed;
    }
  }
  DropGone();
}

void IgtlServer::Write(Client& client, std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  if (client.gone || bytes.empty()) return;
  const ssize_t n = send(client.socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (n < 0 && !WouldBlock(errno)) {
    client.gone = true;
    return;
  }
  const std::size_t taken = n < 0 ? 0 : static_cast<std::size_t>(n);
  if (taken > 0) client.took_ns = now_ns;
  client.rest.assign(bytes.begin() + static_cast<std::ptrdiff_t>(taken), bytes.end());
}

bool IgtlServer::MakeRoom(std::uint32_t address) {
  if (clients_.size() < kMostClients) return true;
  std::map<std::uint32_t, std::size_t> places;
  for (const Client& client : clients_) ++places[client.address];
  const auto most =
      *std::ranges::max_element(places, {}, [](const auto& entry) { return entry.second; });
  const std::size_t own = places[address];
  // A difference of one connection must not make two addresses take places from each other in turn.
  const std::uint32_t gives = most.second > own + 1 ? most.first : address;
  if (gives == address && own == 0) return false;
  Client* leaves = nullptr;
  for (Client& client : clients_) {
    if (client.address != gives) continue;
    if (!leaves || (leaves->rest.empty() && !client.rest.empty())) leaves = &client;
  }
  leaves->gone = true;
  ++counts_.displaced;
  DropGone();
  return true;
}

void IgtlServer::DropGone() {
  for (const Client& client : clients_) {
    if (client.gone) close(client.socket);
  }
  std::erase_if(clients_, [](const Client& client) { return client.gone; });
}

}  // namespace palpate
