#pragma once

#include <optional>
#include <set>
#include <string>

namespace palpate {

/// Returns a process that has one of these sockets open; nothing if there is none that this user
/// may inspect.
/// @param sockets  as /proc/PID/fd names them: "socket:[INODE]".
std::optional<int> SocketOwner(const std::set<std::string>& sockets);

}  // namespace palpate
