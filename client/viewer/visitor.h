#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/tcp.hpp>

namespace palpate {

/// The peer of a connection, as shares, limits and the log name it.
struct Visitor {
  std::string name;       ///< for people to read: "192.168.0.7:50312"
  std::string address;    ///< unit of shares: an IPv4 address, or an IPv6 network (/64)
  bool is_local = false;  ///< this host itself, and not through a proxy
};

/// Returns the addresses of this host: those that others can reach first, loopback last.  IPv6
/// link-local addresses are left out, since they mean nothing without the client's interface.
/// @param v6  include IPv6 addresses.
std::vector<boost::asio::ip::address> HostAddresses(bool v6);

/// Returns whether the address is a proxy's, also in the IPv4-mapped form of an IPv6 socket.
bool IsProxy(const boost::asio::ip::address& address,
             const std::vector<boost::asio::ip::address>& proxies);

/// @param forwarded  X-Forwarded-For (or Forwarded), as received.  Only a proxy's is believed, and
/// of that only the last address, which the proxy has seen itself; from anybody else the header
/// only shows that the visitor is not local.
/// @param proxies  their addresses.  A connection from one is never local.
Visitor VisitorAt(const boost::asio::ip::tcp::endpoint& peer, std::string_view forwarded,
                  const std::vector<boost::asio::ip::address>& proxies);

}  // namespace palpate
