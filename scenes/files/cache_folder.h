#pragma once

#include <string>

namespace palpate {

/// Returns the folder of built scenes: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate.  Empty if
/// there is no home either: then nothing is cached.
std::string DefaultCacheFolder();

/// Creates the folder if needed, for this user alone.  What is read from the cache is felt, and is
/// not checked against its source.  So throws Error (folder, remedy) if the folder belongs to
/// another user, except root, or if others may write to it.
void PrepareCacheFolder(const std::string& folder);

/// Returns whether it is a regular file of this user or of root; false for a link.
bool IsOwnFile(const std::string& file);

}  // namespace palpate
