#pragma once

#include <string>

#include "common/whole_file.h"

namespace palpate {

/// For ReadWholeFile, of what others must not read, as a key, or write, as a list of tokens: the
/// file belongs to this user or root, others have no right to it, and the group cannot write it
/// (0600, 0400, 0640).  Throws Error, with the remedy.
/// @param flag  that named it: "--tokens".
FileCheck IsPrivate(const std::string& flag, const std::string& path);

}  // namespace palpate
