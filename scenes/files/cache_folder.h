#pragma once

#include <string>

namespace palpate {

/// Where built scenes are kept: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate.  Empty where there
/// is no home either: nothing is cached then.
std::string DefaultCacheFolder();

/// Makes the folder where there is none, for this user alone.  What is read from it is felt, and
/// nothing but its bytes says what it is of: so throws Error (folder, remedy) where the folder is
/// another user's, or others may write to it.  Root's is as good as one's own.
void PrepareCacheFolder(const std::string& folder);

/// True for a file of this user's or of root's.  False for all else, such as a link.
bool IsOwnFile(const std::string& file);

}  // namespace palpate
