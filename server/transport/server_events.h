#pragma once

#include <cstdint>
#include <functional>

#include "common/dds/wire.h"

namespace palpate {

/// What a server tells whoever keeps a record of it, after it has published it: all in the thread
/// that calls Poll, and in its destructor.  Any may be empty; none throws.
struct ServerEvents {
  std::function<void(const wire::SessionState&)> session;
  std::function<void(std::uint64_t)> untold;  ///< refusals that were too many to be published
  std::function<void(const wire::SceneWhole&)> whole;
  std::function<void(const wire::LoopStatistics&)> statistics;  ///< per station and second
};

}  // namespace palpate
