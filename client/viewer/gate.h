#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/viewer/refusal_log.h"
#include "client/viewer/tokens.h"

namespace palpate {

/// Returns the most that a page may do, judged by its Origin.
/// Browsers let any web page open a socket to this host, and state the page's origin in that
/// header.  This gateway's own page (the same authority as Host, which IsOwnHost has accepted) may
/// do everything, and so may a client without Origin, which is no browser.  Pages of
/// `allowed_origins` may drive; teachers decide on this gateway's page only.  `file://` may watch:
/// the desktop applications of Foxglove and Lichtblick send it, and no web page can.  All others
/// may do nothing, including sandboxed pages ("null").
/// @param secure  over TLS; a page that was loaded in the clear is then not this gateway's own.
Access AccessOfOrigin(std::string_view origin, std::string_view host, bool secure,
                      const std::vector<std::string>& allowed_origins);

/// What a request says about its sender, not yet verified: the headers as received, empty if
/// absent, and the number of those that may occur once only.
struct Asker {
  std::string_view host;
  std::string_view origin;
  std::string_view authorization;
  std::string_view subprotocols;
  int hosts = 0;
  int authorizations = 0;
  bool is_local = false;   ///< from this host, not through a proxy
  bool is_secure = false;  ///< over TLS
};

/// The gate's decision about a request.
struct Verdict {
  Access access = Access::kNone;
  std::optional<Tokens::Holder> holder;  ///< of its token; nothing: it has none

  // Set if access is kNone.
  int status = 0;  ///< HTTP status
  Refusal refusal = Refusal::kRequest;
  std::string reason;  ///< for the client and the log; names the flag
};

/// Decides who may do what: the only place that does so, for every request, from its Host, its
/// token and its Origin.  Knows no socket.
class Gate {
 public:
  struct Options {
    std::vector<std::string> host_names;  ///< in lower case
    std::vector<std::string> origins;     ///< of other pages that may attach; "*": any
  };
  /// @param tokens  nothing: no token is required.
  Gate(Options options, std::optional<Tokens> tokens)
      : options_(std::move(options)), tokens_(std::move(tokens)) {}

  /// Replaces all valid tokens.
  void Replace(Tokens tokens) { tokens_ = std::move(tokens); }
  const std::optional<Tokens>& tokens() const { return tokens_; }

  /// To be called for every request.  Access::kWatch means no more than "go on" here.
  Verdict JudgeHost(const Asker& asker) const;
  /// For resources that depend on who asks: scenes, health.  After JudgeHost.
  Verdict JudgeToken(const Asker& asker) const;
  /// For a WebSocket, and with it all commands of its page.  After JudgeHost.
  Verdict JudgeSocket(const Asker& asker) const;

 private:
  Options options_;
  std::optional<Tokens> tokens_;
};

}  // namespace palpate
