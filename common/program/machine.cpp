#include "common/program/machine.h"

#include <fstream>

#include <sched.h>

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

int CoresAllowed() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  return sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : 0;
}

}  // namespace

HostMachine ThisHost() {
#ifdef NDEBUG
  const std::string build = ", optimised";
#else
  const std::string build = ", with assertions: times mean nothing";
#endif
  return {.cpu = ProcessorName(), .cores = CoresAllowed(), .compiler = "GCC " __VERSION__ + build};
}

}  // namespace palpate
