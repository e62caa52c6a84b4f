#pragma once

#include <string>

#include <unistd.h>

#include "common/dds/participant.h"
#include "tests/support/test_domain.h"

namespace palpate::dds {

inline const int kDomain = test::OwnDomain();
inline const TransportChoice kUdp{Transport::kUdp, ""};

/// A topic that no other process's test uses.
inline std::string OwnTopic(const std::string& name) {
  return "test/" + std::to_string(getpid()) + "/" + name;
}

}  // namespace palpate::dds
