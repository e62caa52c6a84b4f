#include "client/viewer/visitor.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

namespace palpate {
namespace {

namespace ip = boost::asio::ip;

/// An IPv6 host may use any number of addresses within its own /64 network.
std::string ShareOf(const ip::address& address) {
  if (address.is_v4()) return address.to_string();
  auto bytes = address.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return ip::address_v6(bytes).to_string() + "/64";
}

/// An IPv6 socket that also accepts IPv4 shows it as ::ffff:192.168.0.7.
ip::address Plain(const ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return ip::make_address_v4(ip::v4_mapped, address.to_v6());
  }
  return address;
}

std::optional<ip::address> LastAddress(std::string_view list) {
  std::string last(list.substr(list.rfind(',') + 1));
  std::erase(last, ' ');
  boost::system::error_code error;
  const ip::address address = ip::make_address(last, error);
  if (error) return std::nullopt;
  return Plain(address);
}

ip::address AddressOf(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, address, sizeof v4);
    return ip::address_v4(ntohl(v4.sin_addr.s_addr));
  }
  sockaddr_in6 v6{};
  std::memcpy(&v6, address, sizeof v6);
  ip::address_v6::bytes_type bytes;
  std::memcpy(bytes.data(), &v6.sin6_addr, bytes.size());
  return ip::address_v6(bytes);
}

}  // namespace

std::vector<ip::address> HostAddresses(bool v6) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) list = nullptr;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, freeifaddrs);
  std::vector<ip::address> addresses;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || (i->ifa_flags & IFF_UP) == 0) continue;
    const int family = i->ifa_addr->sa_family;
    if (family != AF_INET && !(v6 && family == AF_INET6)) continue;
    const ip::address address = AddressOf(i->ifa_addr);
    if (address.is_v6() && address.to_v6().is_link_local()) continue;
    addresses.push_back(address);
  }
  std::stable_partition(addresses.begin(), addresses.end(),
                        [](const auto& address) { return !address.is_loopback(); });
  return addresses;
}

bool IsProxy(const ip::address& address, const std::vector<ip::address>& proxies) {
  return std::ranges::find(proxies, Plain(address)) != proxies.end();
}

Visitor VisitorAt(const ip::tcp::endpoint& peer, std::string_view forwarded,
                  const std::vector<ip::address>& proxies) {
  const ip::address address = Plain(peer.address());
  const bool is_proxy = IsProxy(address, proxies);
  if (const auto seen = is_proxy ? LastAddress(forwarded) : std::nullopt) {
    return {fmt::format("{} (by the proxy {})", seen->to_string(), address.to_string()),
            ShareOf(*seen), false};
  }
  std::ostringstream name;
  name << ip::tcp::endpoint(address, peer.port());
  return {name.str(), ShareOf(address), address.is_loopback() && forwarded.empty() && !is_proxy};
}

}  // namespace palpate
