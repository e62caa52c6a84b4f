#pragma once

#include <string>

namespace palpate {

/// A file that others must not read, as a key, or write, as a list of tokens: it is a regular one
/// of this user or root, which others have no right to and the group cannot write (0600, 0400,
/// 0640).  Throws Error, with the remedy.
/// @param flag  that named it: "--tokens".
void CheckPrivate(const std::string& flag, const std::string& path);

}  // namespace palpate
