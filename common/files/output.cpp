#include "common/files/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

[[noreturn]] void Fail(const std::string& option, const std::string& file, int error) {
  throw Error(option + " " + file + ": cannot be written (" + std::strerror(error) +
              "); give a file in a folder that you may write");
}

}  // namespace

void WriteOutput(const std::string& option, const std::string& file, const std::string& text,
                 Links links) {
  errno = 0;
  if (file == "-") {
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) Fail(option, file, errno);
    return;
  }
  // Writes a new file and renames it, so that the old or the new file is complete at any time.
  // Devices, pipes and targets of links are written directly.
  std::error_code none;
  const auto type = std::filesystem::symlink_status(file, none).type();
  const bool in_place = links == Links::kFollow && type != std::filesystem::file_type::regular &&
                        type != std::filesystem::file_type::not_found;
  const std::string written = in_place ? file : file + "." + std::to_string(getpid()) + ".new";
  if (links == Links::kReplace) std::remove(written.c_str());  // whoever has made it
  std::ofstream out(written, std::ios::binary);
  out << text;
  out.close();
  if (out && (in_place || std::rename(written.c_str(), file.c_str()) == 0)) return;
  const int error = errno;
  if (!in_place) std::remove(written.c_str());
  Fail(option, file, error);
}

void CheckOutput(const std::string& option, const std::string& file) {
  errno = 0;
  if (file != "-" && !std::ofstream(file, std::ios::app)) Fail(option, file, errno);
}

}  // namespace palpate
