#pragma once

#include <string>

#include "common/files/whole_file.h"

namespace palpate {

/// For ReadWholeFile, of what others must not read, as a key, or write, as a list of tokens: the
/// file belongs to this user or root, others have no right to it, and the group cannot write it
/// (0600, 0400, 0640).  Throws Error, with the remedy.
/// @param flag  that named it: "--tokens".
FileCheck IsPrivate(const std::string& flag, const std::string& path);

/// Whatever this process writes from now on, of what people did with their hands, is not for others
/// to read: new files have no right for them, and for the group what the umask leaves it (0640 with
/// the usual 022).  To be called before threads are.
void KeepFilesPrivate();

}  // namespace palpate
