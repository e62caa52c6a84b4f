#include "client/viewer/gate.h"

#include <algorithm>

#include "common/http/host_name.h"
#include "common/text/lower_case.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// Prefix of a token among a WebSocket's subprotocols, the only header that a browser lets
/// a page set.
constexpr std::string_view kTokenSubprotocol = "palpate.token.";

constexpr int kBadRequest = 400;
constexpr int kUnauthorized = 401;
constexpr int kForbidden = 403;

Verdict Refused(int status, Refusal refusal, std::string reason) {
  return {Access::kNone, std::nullopt, status, refusal, std::move(reason)};
}

/// Returns the tokens that a request presents, wherever they stand.
std::vector<std::string_view> Presented(const Asker& asker) {
  std::vector<std::string_view> tokens;
  constexpr std::string_view kScheme = "bearer ";
  const std::string_view header = Trimmed(asker.authorization);
  if (LowerCase(header.substr(0, kScheme.size())) == kScheme) {
    tokens.push_back(Trimmed(header.substr(kScheme.size())));
  } else if (!header.empty()) {
    tokens.emplace_back();  // another scheme: counts as an unknown token
  }
  std::string_view rest = asker.subprotocols;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view entry = Trimmed(rest.substr(0, comma));
    if (entry.starts_with(kTokenSubprotocol)) {
      tokens.push_back(entry.substr(kTokenSubprotocol.size()));
    }
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return tokens;
}

}  // namespace

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
  // Compared without the scheme: a proxy in front of this gateway may provide TLS.
  if (host.empty()) return Access::kNone;
  if (from == "https" + own || (!secure && from == "http" + own)) return Access::kOperate;
  return Access::kNone;
}

Verdict Gate::JudgeHost(const Asker& asker) const {
  if (auto refusal = RefuseHost(asker.hosts, asker.host, options_.host_names, "palpate-viewer")) {
    return Refused(refusal->status, Refusal::kHost, std::move(refusal->reason));
  }
  return {Access::kWatch, std::nullopt, 0, Refusal::kHost, ""};
}

Verdict Gate::JudgeToken(const Asker& asker) const {
  if (!tokens_) return {Access::kOperate, std::nullopt, 0, Refusal::kToken, ""};
  const std::vector<std::string_view> presented = Presented(asker);
  if (presented.empty()) {
    return Refused(kUnauthorized, Refusal::kToken,
                   "it has no token; give one as 'Authorization: Bearer TOKEN', or open the page "
                   "with #token=TOKEN at the end of its address");
  }
  if (presented.size() > 1 || asker.authorizations > 1) {
    return Refused(kBadRequest, Refusal::kToken, "it gives more than one token");
  }
  const auto holder = tokens_->Find(presented.front());
  if (!holder) {
    // The presented text is not logged: it may be a valid token with a typing error.
    return Refused(kUnauthorized, Refusal::kToken,
                   "its token is not known to this gateway (palpate-viewer --tokens)");
  }
  return {holder->role, holder, 0, Refusal::kToken, ""};
}

Verdict Gate::JudgeSocket(const Asker& asker) const {
  const Access page = AccessOfOrigin(asker.origin, asker.host, asker.is_secure, options_.origins);
  if (page == Access::kNone) {
    return Refused(kForbidden, Refusal::kOrigin,
                   "a page from elsewhere may not attach: its Origin is " + Quoted(asker.origin) +
                       "; palpate-viewer --allow-origin lets it in");
  }
  Verdict verdict = JudgeToken(asker);
  // Without tokens, only a client on this host may operate.
  if (!tokens_ && !asker.is_local) verdict.access = Access::kDrive;
  verdict.access = std::min(verdict.access, page);
  return verdict;
}

}  // namespace palpate
