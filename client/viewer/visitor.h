#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/tcp.hpp>

namespace palpate {

/// Who is at the other end of a connection, as shares, limits and the log name it.
struct Visitor {
  std::string name;       ///< for people: "192.168.0.7:50312"
  std::string address;    ///< what a share is of: an IPv4 address, or a network of IPv6 (/64)
  bool is_local = false;  ///< this host itself, and nobody whom a proxy of it speaks for
};

/// Where this host is reached: by others first, by itself last.  Link-local addresses of IPv6,
/// which mean nothing without an interface of whoever asks, are left out.
/// @param v6  also those of IPv6.
std::vector<boost::asio::ip::address> HostAddresses(bool v6);

/// True for the address of a proxy, also where a socket of IPv6 says it.
bool IsProxy(const boost::asio::ip::address& address,
             const std::vector<boost::asio::ip::address>& proxies);

/// @param forwarded  X-Forwarded-For (or Forwarded), as it came.  Believed of a proxy alone, and
/// then the last address, which is the one that the proxy has seen; of others it only says that
/// they are not local.
/// @param proxies  addresses of those that are.  What comes from there is never local.
Visitor VisitorAt(const boost::asio::ip::tcp::endpoint& peer, std::string_view forwarded,
                  const std::vector<boost::asio::ip::address>& proxies);

}  // namespace palpate
