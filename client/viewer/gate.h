#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/viewer/refusal_log.h"
#include "client/viewer/tokens.h"

namespace palpate {

/// The most that a page may do.
/// Browsers let any page of the web open a socket to this host, and say in Origin whose page it is.
/// This gateway's own (the same authority as Host, which IsOwnHost has passed), and what sends no
/// Origin and so is no browser, may do all.  Those that are allowed may drive: a teacher's
/// decisions are made on this gateway's page.  A page of this host's files, `file://`, may watch:
/// that is how the desktop applications of Foxglove and Lichtblick name themselves, and no page of
/// the web can. All others, sandboxed ones ("null") among them, may do nothing.
/// @param secure  over TLS: then a page that came in the clear is not this gateway's own.
Access AccessOfOrigin(std::string_view origin, std::string_view host, bool secure,
                      const std::vector<std::string>& allowed_origins);

/// What a request says of who asks, before any of it is believed: headers as they came, empty where
/// there are none, and how many there are of those of which there may be one.
struct Asker {
  std::string_view host;
  std::string_view origin;
  std::string_view authorization;
  std::string_view subprotocols;
  int hosts = 0;
  int authorizations = 0;
  bool is_local = false;   ///< comes from this host, and through no proxy
  bool is_secure = false;  ///< over TLS
};

/// What a request is given.
struct Verdict {
  Access access = Access::kNone;
  std::optional<Tokens::Holder> holder;  ///< of its token; nothing: without one

  // Where access is kNone.
  int status = 0;  ///< of HTTP
  Refusal refusal = Refusal::kRequest;
  std::string reason;  ///< for whoever asks, and for the log; names the flag
};

/// Who may: the one place that decides it, for every request, by its Host, its token and its
/// Origin.  Knows no socket.
class Gate {
 public:
  struct Options {
    std::vector<std::string> host_names;  ///< in small letters
    std::vector<std::string> origins;     ///< of other pages; "*": of any
  };
  /// @param tokens  nothing: none are asked for.
  Gate(Options options, std::optional<Tokens> tokens)
      : options_(std::move(options)), tokens_(std::move(tokens)) {}

  /// From now on these hold, and no others.
  void Replace(Tokens tokens) { tokens_ = std::move(tokens); }
  const std::optional<Tokens>& tokens() const { return tokens_; }

  /// For every request.  Access::kWatch is no more here than "go on".
  Verdict JudgeHost(const Asker& asker) const;
  /// For what is not the same for everybody: scenes, health.  After JudgeHost.
  Verdict JudgeToken(const Asker& asker) const;
  /// For a WebSocket, and so for all that its page may do.  After JudgeHost.
  Verdict JudgeSocket(const Asker& asker) const;

 private:
  Options options_;
  std::optional<Tokens> tokens_;
};

}  // namespace palpate
