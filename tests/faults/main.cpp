// fault_harness: does what can go wrong in a laboratory to the real programs, and prints a table of
// what had to hold nevertheless.
#include <cstdio>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "tests/faults/faults.h"

namespace palpate::faults {
namespace {

constexpr const char* kAbout =
    R"(Does to real programs what goes wrong in a laboratory: kills and freezes each, fills disks, sends
anything at all, and looks at what must be true nevertheless.  Prints a table.  Exit status: 0 where
all held, 1 where something did not.
)";
constexpr const char* kExample = R"(Examples:
  fault_harness                        all, some minutes
  fault_harness --only server-killed
  fault_harness --random 50 --seed 7   fifty faults one after another, as the seed says)";

struct Options {
  std::vector<std::string> only;
  bool list = false;
  int random = 0;
  std::uint64_t seed = 1;
  int domain = 100;
  std::string log_level = "warn";
};

/// Prints a fault's findings; returns how many did not hold.
int Print(const std::string& name, const std::string& story, const std::vector<Finding>& findings) {
  int broken = 0;
  std::printf("%s: %s\n", name.c_str(), story.c_str());
  for (const Finding& finding : findings) {
    std::printf("  %-4s %s: %s\n", finding.held ? "ok" : "NOT", finding.must.c_str(),
                finding.found.c_str());
    broken += !finding.held;
  }
  std::fflush(stdout);
  return broken;
}

/// Runs a fault; that a program does not come up is a finding, too.
std::vector<Finding> Try(const std::function<std::vector<Finding>()>& run) {
  try {
    return run();
  } catch (const Error& error) {
    return {{"every program comes up", error.what(), false}};
  }
}

int Run(const Options& options) {
  int broken = 0, all = 0;
  const auto count = [&](const std::string& name, const std::string& story,
                         const std::vector<Finding>& findings) {
    all += static_cast<int>(findings.size());
    broken += Print(name, story, findings);
  };
  if (options.random > 0) {
    count("random", fmt::format("{} faults, seed {}", options.random, options.seed),
          Try([&] { return RandomFaults(options.domain, options.seed, options.random); }));
  } else {
    for (const std::string& name : options.only) {
      if (std::ranges::find(AllFaults(), name, &Fault::name) == AllFaults().end()) {
        throw UsageError("--only " + name + ": there is no such fault; --list names all");
      }
    }
    for (const Fault& fault : AllFaults()) {
      if (options.list) {
        std::printf("%-16s %s\n", fault.name.c_str(), fault.story.c_str());
        continue;
      }
      const bool wanted =
          options.only.empty() || std::ranges::find(options.only, fault.name) != options.only.end();
      if (wanted) count(fault.name, fault.story, Try([&] { return fault.run(options.domain); }));
    }
    if (options.list) return 0;
  }
  std::printf("%d of %d held\n", all - broken, all);
  return broken == 0 ? 0 : 1;
}

std::optional<Options> Parse(int argc, char** argv) {
  Options options;
  const CommandLine app(kAbout, "fault_harness");
  app.Footer(kExample);
  app.Add("--only", options.only, "these faults alone");
  app.AddFlag("--list", options.list, "names them");
  app.Add("--random", options.random, "so many faults, drawn by --seed").Range(1, 100000);
  app.Add("--seed", options.seed).ShowDefault();
  AddCommonOptions(app, "where the programs meet: a domain that nobody else uses", options.domain,
                   options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  return options;
}

}  // namespace
}  // namespace palpate::faults

int main(int argc, char** argv) {
  return palpate::RunProgram("fault_harness", [&] {
    const auto options = palpate::faults::Parse(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("fault_harness", options->log_level);
    return palpate::faults::Run(*options);
  });
}
