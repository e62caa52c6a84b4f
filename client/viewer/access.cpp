#include "client/viewer/access.h"

#include <algorithm>
#include <cctype>

#include <boost/asio/ip/address.hpp>

namespace palpate {
namespace {

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

/// "[::1]:80" -> "::1", "localhost:80" -> "localhost"
std::string HostOnly(const std::string& authority) {
  if (authority.starts_with('[')) return authority.substr(1, authority.find(']') - 1);
  return authority.substr(0, authority.find(':'));
}

bool IsAddressOrLocalhost(const std::string& host) {
  boost::system::error_code error;
  boost::asio::ip::make_address(host, error);
  return !error || host == "localhost";
}

}  // namespace

Access AccessOf(std::string_view origin, std::string_view host, bool loopback_only,
                const std::vector<std::string>& allowed_origins) {
  if (origin.empty()) return Access::kAll;
  const std::string from = Lower(origin);
  if (std::ranges::any_of(allowed_origins, [&](const std::string& allowed) {
        return allowed == "*" || Lower(allowed) == from;
      })) {
    return Access::kAll;
  }
  if (from == "file://") return Access::kLook;
  const std::size_t scheme = from.find("://");
  if (scheme == std::string::npos) return Access::kNone;
  const std::string authority = from.substr(scheme + 3);
  const bool own = !authority.empty() && authority == Lower(host) &&
                   (!loopback_only || IsAddressOrLocalhost(HostOnly(authority)));
  return own ? Access::kAll : Access::kNone;
}

}  // namespace palpate
