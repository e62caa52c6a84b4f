#include "common/files/private_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {

FileCheck IsPrivate(const std::string& flag, const std::string& path) {
  return [flag, path](const struct stat& file) {
    if (file.st_uid != geteuid() && file.st_uid != 0) {
      throw Error(
          fmt::format("{} {}: belongs to another user, who could change it; chown it", flag, path));
    }
    if ((file.st_mode & (S_IWGRP | S_IRWXO)) != 0) {
      throw Error(
          fmt::format("{} {}: has mode {:04o}, so others may read or change it; chmod 0600 it",
                      flag, path, file.st_mode & 07777));
    }
  };
}

void KeepFilesPrivate() {
  umask(umask(S_IRWXO) | S_IRWXO);
}

}  // namespace palpate
