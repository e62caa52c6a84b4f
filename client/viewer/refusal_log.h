#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/realtime/rate_limit.h"

namespace palpate {

/// Why a client is refused; each kind is logged at most once a second.
enum class Refusal {
  kHost,     ///< a Host other than this gateway's
  kOrigin,   ///< a page from another origin
  kToken,    ///< no token, or an unknown one
  kRole,     ///< a token or page that may do less
  kRequest,  ///< malformed or not understood
  kTls,      ///< plain HTTP where TLS is required
  kFull,     ///< no room for one more viewer
  kTakes,    ///< tools taken too often
  kWishes,   ///< anything else requested too often
  kFlood,    ///< messages arriving faster than they are read
};

/// Logs refusals: all of them are counted, and their lines are limited in rate so that they cannot
/// fill the disk.
/// Thread contract: one thread.  Times are in nanoseconds.
class RefusalLog {
 public:
  static constexpr std::size_t kKinds = 10;
  /// @param who   an address.   @param what  a sentence; text from the client must be Quoted.
  void Say(Refusal kind, const std::string& who, const std::string& what, std::int64_t now_ns);
  /// Logs the number of suppressed lines of a kind after a second without a new one.
  void Poll(std::int64_t now_ns);
  /// Refusals of all kinds, including those whose lines were suppressed.
  std::uint64_t count() const { return count_; }

 private:
  std::array<RateLimit, kKinds> limits_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
