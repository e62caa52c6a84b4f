#include "common/http/host_name.h"

#include <algorithm>

#include <arpa/inet.h>

#include "common/text/lower_case.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestName = 253;  // RFC 1035

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Returns the host of "host" or "host:port"; nothing if the rest is no port.
std::optional<std::string_view> WithoutPort(std::string_view authority, std::size_t host_ends) {
  const std::string_view rest = authority.substr(host_ends);
  const bool is_port = rest.size() > 1 && rest.size() <= 6 && rest.front() == ':' &&
                       std::all_of(rest.begin() + 1, rest.end(), IsDigit);
  if (!rest.empty() && !is_port) return std::nullopt;
  return authority.substr(0, host_ends);
}

bool IsAddress(int family, std::string_view text) {
  in6_addr address;
  return inet_pton(family, std::string(text).c_str(), &address) == 1;
}

}  // namespace

bool IsHostName(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, [](char c) {
    return IsDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_' ||
           c == '.';
  });
}

bool IsOwnHost(std::string_view authority, const std::vector<std::string>& names) {
  if (authority.starts_with('[')) {
    const std::size_t end = authority.find(']');
    if (end == std::string_view::npos) return false;
    const auto host = WithoutPort(authority, end + 1);
    if (!host) return false;
    const std::string_view address = host->substr(1, end - 1);
    // inet_pton stops at a zero byte.  A zone (%eth0) is not accepted; no browser sends one.
    return address.find('\0') == std::string_view::npos && IsAddress(AF_INET6, address);
  }
  const auto host = WithoutPort(authority, std::min(authority.find(':'), authority.size()));
  if (!host || !IsHostName(*host)) return false;
  const std::string name = LowerCase(*host);
  if (name == "localhost" || std::ranges::find(names, name) != names.end()) return true;
  return IsAddress(AF_INET, name);  // four numbers; other notations are not accepted
}

std::optional<HostRefusal> RefuseHost(int hosts, std::string_view authority,
                                      const std::vector<std::string>& names,
                                      const std::string& program) {
  constexpr int kBadRequest = 400, kMisdirected = 421;
  if (hosts != 1) {
    return HostRefusal{kBadRequest, "a request names one Host, not " + std::to_string(hosts)};
  }
  if (IsOwnHost(authority, names)) return std::nullopt;
  return HostRefusal{kMisdirected, "its Host is " + Quoted(authority) +
                                       ", which is no address in numbers, nor localhost; " +
                                       program +
                                       " --host-name lets it in, where that name is this host's"};
}

}  // namespace palpate
