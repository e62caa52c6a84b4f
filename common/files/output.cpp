#include "common/files/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "common/error.h"

namespace palpate {
namespace {

[[noreturn]] void Fail(const std::string& option, const std::string& file, int error) {
  throw Error(option + " " + file + ": cannot be written (" + std::strerror(error) +
              "); give a file in a folder that you may write");
}

}  // namespace

void WriteOutput(const std::string& option, const std::string& file, const std::string& text) {
  errno = 0;
  if (file == "-") {
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) Fail(option, file, errno);
    return;
  }
  std::ofstream out(file);
  if (!(out << text) || !out.flush()) Fail(option, file, errno);
}

void CheckOutput(const std::string& option, const std::string& file) {
  errno = 0;
  if (file != "-" && !std::ofstream(file, std::ios::app)) Fail(option, file, errno);
}

}  // namespace palpate
