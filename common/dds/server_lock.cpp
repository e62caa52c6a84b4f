#include "common/dds/server_lock.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <netinet/in.h>
#include <pwd.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/dds/socket_owner.h"
#include "common/error.h"

namespace palpate {
namespace {

std::vector<dds::UdpSocket> SocketsOnThisHost() {
  std::ifstream in("/proc/net/udp");
  return dds::UdpSocketsIn(in);
}

std::optional<dds::UdpSocket> HolderOf(int domain, const std::vector<dds::UdpSocket>& sockets) {
  const auto holder = std::ranges::find(sockets, ServerPort(domain), &dds::UdpSocket::port);
  return holder == sockets.end() ? std::nullopt : std::optional(*holder);
}

std::optional<int> ProcessOf(const dds::UdpSocket& socket) {
  return SocketOwner({"socket:[" + std::to_string(socket.inode) + "]"});
}

/// Returns "palpate-server (pid 7)", or as much of it as this user may know.
std::string NameOf(const dds::UdpSocket& socket) {
  if (const std::optional<int> pid = ProcessOf(socket)) {
    std::string name;
    std::getline(std::ifstream("/proc/" + std::to_string(*pid) + "/comm"), name);
    return (name.empty() ? "another program" : name) + " (pid " + std::to_string(*pid) + ")";
  }
  const passwd* const user = getpwuid(socket.user);
  return "a program of user " + (user ? std::string(user->pw_name) : std::to_string(socket.user));
}

/// Returns true if the holder of the server's port may be a server: it belongs to this user or
/// root, or holds more of the domain's ports.
bool TakesPart(const dds::UdpSocket& holder, int domain,
               const std::vector<dds::UdpSocket>& sockets) {
  if (holder.user == geteuid() || holder.user == 0) return true;
  const dds::PortRange loop = dds::PortsOf(dds::LoopDomainId(domain));
  const dds::PortRange service = dds::PortsOf(dds::ServiceDomainId(domain));
  return std::ranges::any_of(sockets, [&](const dds::UdpSocket& socket) {
    return socket.user == holder.user && socket.inode != holder.inode &&
           (loop.Has(socket.port) || service.Has(socket.port));
  });
}

}  // namespace

ServerLock::ServerLock(int domain) : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const std::string number = std::to_string(domain);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(ServerPort(domain)));
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (socket_ >= 0 && bind(socket_, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0) return;
  const int error = errno;
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  const std::vector<dds::UdpSocket> sockets = SocketsOnThisHost();
  const auto holder = HolderOf(domain, sockets);
  if (error != EADDRINUSE || !holder) {
    throw Error("domain " + number + ": UDP port " + std::to_string(ServerPort(domain)) +
                " cannot be opened (" + std::strerror(error) + "); give another --domain");
  }
  if (TakesPart(*holder, domain, sockets)) {
    throw Error("domain " + number + " is in use by " + NameOf(*holder) +
                "; stop that one, or give another --domain");
  }
  spdlog::warn(
      "UDP port {}, which marks the server of domain {}, is used by {}, which does not belong to "
      "the domain: this server continues without the port",
      ServerPort(domain), number, NameOf(*holder));
}

ServerLock::~ServerLock() {
  if (socket_ >= 0) close(socket_);
}

std::optional<int> ServerProcess(int domain) {
  const auto holder = HolderOf(domain, SocketsOnThisHost());
  return holder ? ProcessOf(*holder) : std::nullopt;
}

std::vector<std::pair<int, std::string>> ServersOnThisHost(int most) {
  std::vector<std::pair<int, std::string>> servers;
  const std::vector<dds::UdpSocket> sockets = SocketsOnThisHost();
  for (int domain = 0; domain <= most; ++domain) {
    const auto holder = HolderOf(domain, sockets);
    if (holder && TakesPart(*holder, domain, sockets))
      servers.emplace_back(domain, NameOf(*holder));
  }
  return servers;
}

}  // namespace palpate
