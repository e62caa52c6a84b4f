#include "client/viewer/refusal_log.h"

#include <spdlog/spdlog.h>

namespace palpate {
namespace {

const char* NameOf(Refusal kind) {
  switch (kind) {
    case Refusal::kHost:
      return "host";
    case Refusal::kOrigin:
      return "origin";
    case Refusal::kToken:
      return "token";
    case Refusal::kRole:
      return "role";
    case Refusal::kRequest:
      return "request";
    case Refusal::kTls:
      return "tls";
    case Refusal::kFull:
      return "full";
    case Refusal::kTakes:
      return "takes";
    case Refusal::kWishes:
      return "wishes";
    case Refusal::kFlood:
      return "flood";
  }
  return "?";
}

}  // namespace

void RefusalLog::Say(Refusal kind, const std::string& who, const std::string& what,
                     std::int64_t now_ns) {
  ++count_;
  RateLimit& limit = limits_[static_cast<std::size_t>(kind)];
  if (!limit.Pass(now_ns)) return;
  const std::uint64_t before = limit.TakeHeldBack();
  const std::string more = before > 0 ? fmt::format(" ({} more before it)", before) : "";
  spdlog::warn("refused ({}) {}: {}{}", NameOf(kind), who, what, more);
}

void RefusalLog::Poll(std::int64_t now_ns) {
  for (std::size_t i = 0; i < kKinds; ++i) {
    RateLimit& limit = limits_[i];
    if (!limit.OwesWord(now_ns)) continue;
    const std::uint64_t held_back = limit.TakeHeldBack();
    limit.Pass(now_ns);  // this line is its second's
    spdlog::warn("refused ({}): {} more", NameOf(static_cast<Refusal>(i)), held_back);
  }
}

}  // namespace palpate
