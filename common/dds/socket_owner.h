#pragma once

#include <optional>
#include <set>
#include <string>

namespace palpate {

/// The process that has one of these sockets open, each as /proc/PID/fd names it, "socket:[INODE]".
/// Nothing where none does that this user may look at.
std::optional<int> SocketOwner(const std::set<std::string>& sockets);

}  // namespace palpate
