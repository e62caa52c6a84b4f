#include "scenes/files/cache_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

bool IsOwn(const struct stat& status) {
  return status.st_uid == geteuid() || status.st_uid == 0;
}

}  // namespace

std::string DefaultCacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return (fs::path(cache) / "palpate").string();
  }
  const char* home = std::getenv("HOME");
  return home == nullptr ? "" : (fs::path(home) / ".cache/palpate").string();
}

void PrepareCacheFolder(const std::string& folder) {
  std::error_code ignored;  // mkdir reports the same error
  if (const fs::path parent = fs::path(folder).parent_path(); !parent.empty()) {
    fs::create_directories(parent, ignored);
  }
  struct stat status {};
  const bool is_there = mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST;
  if (!is_there || stat(folder.c_str(), &status) != 0) {
    throw Error(folder + ": " + std::strerror(errno) +
                "; set XDG_CACHE_HOME to a folder that you can write");
  }
  if (!S_ISDIR(status.st_mode)) {
    throw Error(folder + ": is not a folder; move it away, or set XDG_CACHE_HOME to another");
  }
  if (!IsOwn(status)) {
    throw Error(folder + ": belongs to another user (id " + std::to_string(status.st_uid) +
                "), who could put a false scene there; set XDG_CACHE_HOME to a folder of your own");
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw Error(folder +
                ": others can write to it, and could put a false scene there; remove it, and it is "
                "created again for you only");
  }
}

bool IsOwnFile(const std::string& file) {
  struct stat status {};
  return lstat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && IsOwn(status);
}

}  // namespace palpate
