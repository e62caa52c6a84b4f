#pragma once

#include <optional>
#include <string>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"
#include "common/dds/participant.h"

namespace palpate::doctor {

/// What RouDi needs in /dev/shm with the project's pools; a test compares it with them.
inline constexpr long long kSharedMemoryNeeded_MB = 117;

struct Space {
  long long size_MB = 0;
  long long free_MB = 0;
};
/// Of the file system that the folder is on; nothing where there is no such folder.
std::optional<Space> SpaceIn(const HostFiles& host, const std::string& folder);

/// RouDi, the keeper of the shared memory, as this host shows it.
struct RouDiState {
  bool socket = false;   ///< /tmp/roudi is there
  bool answers = false;  ///< and a process holds it open
  /// As a living RouDi holds it, or where that cannot be seen, the socket answers.
  bool lock_held = false;
  /// Its files that are another user's, who alone may start a RouDi while they are there; each with
  /// a space before it.
  std::string closed{};
  long long owner = -1;                ///< user id of the socket's owner
  bool may_connect = false;            ///< this user may open the socket
  std::optional<std::string> pools{};  ///< file that it was started with; "" without one
};
RouDiState LookAtRouDi(const HostFiles& host);

/// @param wanted  kUdp: it is not needed.
Finding CheckSharedMemory(const std::optional<Space>& space, bool roudi_runs,
                          dds::Transport wanted);
/// @param pools  file to start it with, for the remedy.
Finding CheckRouDi(const RouDiState& roudi, dds::Transport wanted, long long user,
                   const std::string& pools);

}  // namespace palpate::doctor
