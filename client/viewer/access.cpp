#include "client/viewer/access.h"

#include <algorithm>

#include "common/text/lower_case.h"

namespace palpate {

const char* RoleName(Access access) {
  static constexpr const char* kNames[] = {"none", "watch", "drive", "operate"};
  return kNames[static_cast<std::size_t>(access)];
}

std::optional<Access> ParseRole(std::string_view name) {
  for (const Access role : {Access::kWatch, Access::kDrive, Access::kOperate}) {
    if (name == RoleName(role)) return role;
  }
  return std::nullopt;
}

Access AccessOfOrigin(std::string_view origin, std::string_view host, bool secure,
                      const std::vector<std::string>& allowed_origins) {
  if (origin.empty()) return Access::kOperate;
  const std::string from = LowerCase(origin);
  if (std::ranges::any_of(allowed_origins, [&](const std::string& allowed) {
        return allowed == "*" || LowerCase(allowed) == from;
      })) {
    return Access::kDrive;
  }
  if (from == "file://") return Access::kWatch;
  const std::string own = "://" + LowerCase(host);
  // In the clear both: a proxy may speak TLS before this gateway.
  if (host.empty()) return Access::kNone;
  if (from == "https" + own || (!secure && from == "http" + own)) return Access::kOperate;
  return Access::kNone;
}

}  // namespace palpate
