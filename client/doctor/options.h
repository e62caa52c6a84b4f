#pragma once

#include <optional>
#include <string>

#include "common/dds/network.h"
#include "common/dds/participant.h"
#include "common/program/realtime.h"

namespace palpate::doctor {

struct Options {
  double seconds = 10.0;  ///< of the jitter test; 0: none
  std::string device{};   ///< as after palpate-station --device; empty: none
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network{};
  RealtimeOptions realtime{};
  bool json = false;
  int domain = 0;
  std::string log_level = "warn";
};

/// Nothing where --help or --version was asked for.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv);

}  // namespace palpate::doctor
