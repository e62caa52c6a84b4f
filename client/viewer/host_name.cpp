#include "client/viewer/host_name.h"

#include <algorithm>
#include <optional>

#include <boost/asio/ip/address.hpp>

#include "client/viewer/lower_case.h"

namespace palpate {
namespace {

namespace ip = boost::asio::ip;

constexpr std::size_t kLongestName = 253;  // RFC 1035

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Of "host" or "host:port" what stands before the port; nothing where the rest is no port.
std::optional<std::string_view> WithoutPort(std::string_view authority, std::size_t host_ends) {
  const std::string_view rest = authority.substr(host_ends);
  const bool is_port = rest.size() > 1 && rest.size() <= 6 && rest.front() == ':' &&
                       std::all_of(rest.begin() + 1, rest.end(), IsDigit);
  if (!rest.empty() && !is_port) return std::nullopt;
  return authority.substr(0, host_ends);
}

}  // namespace

bool IsHostName(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, [](char c) {
    return IsDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_' ||
           c == '.';
  });
}

bool IsOwnHost(std::string_view authority, const std::vector<std::string>& names) {
  boost::system::error_code error;
  if (authority.starts_with('[')) {
    const std::size_t end = authority.find(']');
    if (end == std::string_view::npos) return false;
    const auto host = WithoutPort(authority, end + 1);
    if (!host) return false;
    ip::make_address_v6(std::string(host->substr(1, end - 1)), error);
    return !error;
  }
  const auto host = WithoutPort(authority, std::min(authority.find(':'), authority.size()));
  if (!host || !IsHostName(*host)) return false;
  const std::string name = LowerCase(*host);
  if (name == "localhost" || std::ranges::find(names, name) != names.end()) return true;
  ip::make_address_v4(name, error);  // four numbers: no other spelling of an address
  return !error;
}

}  // namespace palpate
