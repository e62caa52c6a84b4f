#pragma once

#include <string>

#include "common/files/whole_file.h"

namespace palpate {

/// Returns a check for ReadWholeFile of files that others must not read (a key) or write (a list of
/// tokens): the file belongs to this user or root, others have no rights to it, and the group
/// cannot write it (0600, 0400, 0640).  The check throws Error, with the remedy.
/// @param flag  the one that named the file: "--tokens".
FileCheck IsPrivate(const std::string& flag, const std::string& path);

/// Keeps the files that this process creates from now on, which record what people did with their
/// hands, from being read by others: others get no rights, and the group what the umask leaves it
/// (0640 with the usual 022).  Call it before there are threads.
void KeepFilesPrivate();

}  // namespace palpate
