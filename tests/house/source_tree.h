#pragma once

#include <string>
#include <vector>

namespace palpate::house {

/// Files that git tracks or would track, relative to the root, sorted.  Throws Error without git,
/// or if the root is no repository.
std::vector<std::string> SourceFiles(const std::string& root);

/// Files that git tracks: without a user's own meshes and recordings.
std::vector<std::string> TrackedFiles(const std::string& root);

/// What a command on the PATH writes to stdout and stderr together, and its exit code; 127: there
/// is no such command.  The words are passed unchanged, without a shell.
struct Output {
  std::string text;
  int exit_code = 0;
};
Output RunCommand(const std::vector<std::string>& words);

/// Whether the path is the folder (or file) itself, or in it.
bool IsBelow(const std::string& path, const std::string& folder);

}  // namespace palpate::house
