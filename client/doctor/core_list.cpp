#include "client/doctor/core_list.h"

#include <cstdlib>
#include <sstream>

namespace palpate::doctor {
namespace {

constexpr int kMostCores = 8192;  // NR_CPUS of the largest kernels

}  // namespace

std::set<int> ParseCores(const std::string& list) {
  std::set<int> cores;
  std::istringstream ranges(list);
  for (std::string range; std::getline(ranges, range, ',');) {
    char* end = nullptr;
    const long first = std::strtol(range.c_str(), &end, 10);
    if (end == range.c_str()) continue;
    const long last = *end == '-' ? std::strtol(end + 1, nullptr, 10) : first;
    for (long core = first; core <= last && core < kMostCores; ++core) {
      cores.insert(static_cast<int>(core));
    }
  }
  return cores;
}

std::string ToText(const std::set<int>& cores) {
  std::string text;
  for (auto first = cores.begin(); first != cores.end();) {
    auto last = first;
    while (std::next(last) != cores.end() && *std::next(last) == *last + 1) ++last;
    text.append(text.empty() ? "" : ",").append(std::to_string(*first));
    if (last != first) text.append("-").append(std::to_string(*last));
    first = std::next(last);
  }
  return text;
}

}  // namespace palpate::doctor
