#include "common/machine.h"

#include <fstream>
#include <thread>

namespace palpate {
namespace {

std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

HostMachine ThisHost() {
#ifdef NDEBUG
  const std::string build = ", optimised";
#else
  const std::string build = ", with assertions: times mean nothing";
#endif
  return {.cpu = ProcessorName(),
          .cores = static_cast<int>(std::thread::hardware_concurrency()),
          .compiler = "GCC " __VERSION__ + build};
}

}  // namespace palpate
