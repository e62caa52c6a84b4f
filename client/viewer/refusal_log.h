#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/realtime/rate_limit.h"

namespace palpate {

/// Why somebody is turned away; each kind has a line of the log a second at most.
enum class Refusal {
  kHost,     ///< a Host that is not this gateway's
  kOrigin,   ///< a page from elsewhere
  kToken,    ///< no token, or nobody's
  kRole,     ///< a token, or a page, that may do less
  kRequest,  ///< what is no request, or none that is understood
  kTls,      ///< in the clear, where TLS is spoken
  kFull,     ///< no room for one more viewer
  kTakes,    ///< tools taken too often
  kWishes,   ///< anything else wished for too often
  kFlood,    ///< messages faster than they are read
};

/// The log of those who are turned away: every one is counted there, and none can fill the disk.
/// Thread contract: one thread.  Time is given [ns].
class RefusalLog {
 public:
  static constexpr std::size_t kKinds = 10;
  /// @param who   an address.   @param what  a sentence; what outsiders sent in it is Quoted.
  void Say(Refusal kind, const std::string& who, const std::string& what, std::int64_t now_ns);
  /// Tells how many were not told of, once a second has passed without one of their kind.
  void Poll(std::int64_t now_ns);
  /// Of all kinds, told of or not.
  std::uint64_t count() const { return count_; }

 private:
  std::array<RateLimit, kKinds> limits_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
