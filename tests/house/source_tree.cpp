#include "tests/house/source_tree.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "common/error.h"
#include "tests/support/program.h"

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

Output RunCommand(const std::vector<std::string>& words) {
  test::Program program("/usr/bin/env", words);
  const int exit_code = program.Exit(1200.0);  // the trials of packages take long
  return {program.Output(), exit_code};
}

bool IsBelow(const std::string& path, const std::string& folder) {
  return path == folder || path.starts_with(folder + "/");
}

}  // namespace palpate::house
