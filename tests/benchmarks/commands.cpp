#include "tests/benchmarks/commands.h"

#include <charconv>

#include "common/error.h"

namespace palpate::bench {

void AddJson(const CommandLine& command, std::string& file) {
  Add(command, "--json", file, "write one JSON object to this file; -: standard output");
}

void AddModels(const CommandLine& command, std::string& folder) {
  Add(command, "--models", folder, "folder of meshes that no package installs");
}

void AddPathSteps(const CommandLine& command, std::optional<int>& steps) {
  Add(command, "--steps", steps, "number of steps; default: the whole path").Positive();
}

void AddRepeats(const CommandLine& command, int& repeats) {
  Add(command, "--repeats", repeats,
      "number of identical runs; 'best' is the minimum for each step")
      .Positive();
}

std::pair<std::uint64_t, std::uint64_t> SeedRange(const std::string& text) {
  std::uint64_t first = 0, last = 0;
  const char* const end = text.data() + text.size();
  const auto [dots, bad_first] = std::from_chars(text.data(), end, first);
  if (bad_first == std::errc() && end - dots > 2 && dots[0] == '.' && dots[1] == '.') {
    const auto [rest, bad_last] = std::from_chars(dots + 2, end, last);
    if (bad_last == std::errc() && rest == end && first <= last) return {first, last};
  }
  throw UsageError("--seeds " + text + " is no range; give A..B, as 1..20");
}

}  // namespace palpate::bench
