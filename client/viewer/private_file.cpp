#include "client/viewer/private_file.h"

#include <cerrno>
#include <cstring>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {

void CheckPrivate(const std::string& flag, const std::string& path) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) {
    throw Error(fmt::format("{} {}: {}", flag, path, std::strerror(errno)));
  }
  if (!S_ISREG(file.st_mode)) throw Error(fmt::format("{} {}: is no regular file", flag, path));
  if (file.st_uid != geteuid() && file.st_uid != 0) {
    throw Error(
        fmt::format("{} {}: belongs to another user, who could change it; chown it", flag, path));
  }
  if ((file.st_mode & (S_IWGRP | S_IRWXO)) != 0) {
    throw Error(
        fmt::format("{} {}: has mode {:04o}, so that others may read or change it; chmod "
                    "0600 it",
                    flag, path, file.st_mode & 07777));
  }
}

}  // namespace palpate
