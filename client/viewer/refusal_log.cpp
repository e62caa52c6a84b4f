#include "client/viewer/refusal_log.h"

#include <iterator>

#include <spdlog/spdlog.h>

namespace palpate {
namespace {

/// In the order of Refusal.
constexpr const char* kNames[] = {"host", "origin", "token", "role",   "request",
                                  "tls",  "full",   "takes", "wishes", "flood"};

}  // namespace

static_assert(std::size(kNames) == RefusalLog::kKinds);

void RefusalLog::Say(Refusal kind, const std::string& who, const std::string& what,
                     std::int64_t now_ns) {
  ++count_;
  const auto index = static_cast<std::size_t>(kind);
  RateLimit& limit = limits_[index];
  if (!limit.Pass(now_ns)) return;
  const std::uint64_t before = limit.TakeHeldBack();
  const std::string more = before > 0 ? fmt::format(" ({} more before it)", before) : "";
  spdlog::warn("refused ({}) {}: {}{}", kNames[index], who, what, more);
}

void RefusalLog::Poll(std::int64_t now_ns) {
  for (std::size_t i = 0; i < kKinds; ++i) {
    RateLimit& limit = limits_[i];
    if (!limit.OwesWord(now_ns)) continue;
    const std::uint64_t held_back = limit.TakeHeldBack();
    limit.Pass(now_ns);  // this line uses up its second
    spdlog::warn("refused ({}): {} more", kNames[i], held_back);
  }
}

}  // namespace palpate
