#include "tests/house/source_tree.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate::house {

namespace {

std::vector<std::string> ListedFiles(const std::string& root,
                                     const std::vector<std::string>& which) {
  // safe.directory: whoever runs the tests need not own the checkout (containers, CI).
  std::vector<std::string> words = {"git", "-c", "safe.directory=*",   "-C",
                                    root,  "-c", "core.quotePath=off", "ls-files"};
  words.insert(words.end(), which.begin(), which.end());
  const Output listing = RunCommand(words);
  if (listing.exit_code != 0) throw Error("git ls-files in " + root + ": " + listing.text);
  std::vector<std::string> files;
  std::istringstream lines(listing.text);
  for (std::string line; std::getline(lines, line);) {
    if (std::filesystem::is_regular_file(root + "/" + line)) files.push_back(line);
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<std::string> SourceFiles(const std::string& root) {
  return ListedFiles(root, {"--cached", "--others", "--exclude-standard"});
}

std::vector<std::string> TrackedFiles(const std::string& root) {
  return ListedFiles(root, {"--cached"});
}

std::string ReadFile(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file + ": cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Output RunCommand(const std::vector<std::string>& words) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) throw Error(std::string("pipe: ") + std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", 0, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[0]);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[1]);

  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t pid = 0;
  const int failure =
      posix_spawnp(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  if (failure != 0) {
    close(pipe_ends[0]);
    throw Error(words[0] + ": " + std::strerror(failure));
  }

  Output output;
  std::array<char, 4096> buffer;
  for (ssize_t n; (n = read(pipe_ends[0], buffer.data(), buffer.size())) > 0;) {
    output.text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  close(pipe_ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  output.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

bool IsBelow(const std::string& path, const std::string& folder) {
  return path == folder || path.starts_with(folder + "/");
}

}  // namespace palpate::house
