#pragma once

#include <vector>

#include <boost/asio/ip/address.hpp>

namespace palpate {

/// Where this host is reached: by others first, by itself last.  Link-local addresses of IPv6,
/// which mean nothing without an interface of whoever asks, are left out.
/// @param v6  also those of IPv6.
std::vector<boost::asio::ip::address> HostAddresses(bool v6);

}  // namespace palpate
