#pragma once

#include <cstdint>
#include <string>

#include "client/doctor/finding.h"
#include "common/dds/network.h"
#include "common/dds/participant.h"
#include "common/program/realtime.h"
#include "common/program/stop_signal.h"

namespace palpate::doctor {

/// What two processes found that sent poses and echoed wrenches as a station and a server do. Plain
/// data: it comes through a pipe.
struct LoopTrial {
  bool finished = false;  ///< all below counts
  bool shared_memory = false;
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;
  double p50_us = 0.0;  ///< round trip
  double p99_us = 0.0;
  double max_us = 0.0;
  char error[512] = {};  ///< why not finished; empty where it hung or died
};

struct LoopOptions {
  int domain = 0;
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network{};
  RealtimeOptions realtime{};
};

/// Tries it for about a second, in two processes of its own, which a hanging RouDi, or a library
/// that aborts, may take with it.  To be called while this process has no other thread.
/// @param stop  ends it early; made before, so that both processes see a signal, too.
LoopTrial TryLoop(const LoopOptions& options, StopSignal& stop);

/// @param expected  shared memory, or UDP, as ChooseTransport chose.
Finding CheckLoop(const LoopTrial& trial, dds::Transport expected);

}  // namespace palpate::doctor
