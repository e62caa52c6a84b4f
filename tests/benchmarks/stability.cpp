// palpate-bench stability: all hard cases, each with the bound that it must keep.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/program/stop_signal.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/stability_case.h"

namespace palpate::bench {
namespace {

struct StabilityOptions {
  std::string only, json;
  long steps = 200'000;
  bool list = false;
  FeatureOptions features{"surface", "off"};
};

Json ToJson(const StabilityCase& c, const CaseRun& run) {
  return {{"name", c.name},
          {"steps", run.done},
          {"figure", run.figure},
          {"bound", c.bound},
          {"unit", c.unit},
          {"held", Held(c, run)},
          {"what", c.what},
          {"reason", c.reason},
          {"tunnelled", run.tunnelled},
          {"nonfinite", run.nonfinite},
          {"penetration_um", 1e6 * run.penetration}};
}

std::vector<StabilityCase> Chosen(const StabilityOptions& options) {
  std::vector<StabilityCase> cases = StabilityCases();
  std::string names;
  for (const StabilityCase& c : cases) names += "\n  " + c.name;
  const Features features = options.features.features();
  const auto removed = std::erase_if(cases, [&](const StabilityCase& c) {
    return options.only.empty() ? !c.applies(features) : c.name != options.only;
  });
  if (cases.empty())
    throw UsageError("stability: no case '" + options.only + "'; there are" + names);
  if (!options.only.empty() && !cases.front().applies(features)) {
    throw UsageError("stability: case '" + options.only +
                     "' needs another --contact or --friction");
  }
  if (options.only.empty() && removed > 0) {
    fmt::print(stderr, "{} cases ask for another --contact or --friction and are left out\n",
               removed);
  }
  return cases;
}

void Run(const StabilityOptions& options) {
  const std::vector<StabilityCase> cases = Chosen(options);
  if (options.list) {
    for (const StabilityCase& c : cases) {
      fmt::print("{:<24} {} <= {:g} {}\n{:<24}   {}\n", c.name, c.what, c.bound, c.unit, "",
                 c.reason);
    }
    return;
  }
  double shares = 0.0;
  for (const StabilityCase& c : cases) shares += c.share;
  StopSignal stop;
  Json json{{"contact", options.features.contact},
            {"friction", options.features.friction},
            {"machine", ToJson(ThisMachine())},
            {"cases", Json::array()}};
  long held = 0, total = 0, steps = 0, tunnelled = 0, nonfinite = 0;
  double penetration = 0.0;
  fmt::print(stderr, "{:<24} {:>9}  {:>12} {:>9} {:<4}  {:>9}  {}\n", "case", "steps", "figure",
             "bound", "", "overlap um", "");
  for (const StabilityCase& c : cases) {
    CaseRun run;
    run.steps =
        std::max(c.least, std::lround(static_cast<double>(options.steps) * c.share / shares));
    run.features = options.features.features();
    run.stopped = [&] { return stop.stopped(); };
    run.progress = [&](long done) {
      Progress(fmt::format("{}: {:.0f} % of {} steps ...", c.name,
                           100.0 * static_cast<double>(done) / static_cast<double>(run.steps),
                           run.steps));
    };
    Progress(c.name + ": builds its bodies ...");
    try {
      c.run(run);
    } catch (const Interrupted&) {
      Progress("");
      fmt::print(stderr, "interrupted in {}; the cases above stand\n", c.name);
      break;
    }
    Progress("");
    const bool ok = Held(c, run);
    std::string why;
    if (!(run.figure <= c.bound)) why += " figure";
    if (run.tunnelled > 0) why += fmt::format(" {} tunnelled", run.tunnelled);
    if (run.nonfinite > 0) why += fmt::format(" {} not finite", run.nonfinite);
    if (!(run.penetration <= kAllowedOverlap)) why += " overlap";
    fmt::print(stderr, "{:<24} {:>9}  {:>12.4g} {:>9.4g} {:<4}  {:>9.3f}  {}\n", c.name, run.done,
               run.figure, c.bound, c.unit, 1e6 * run.penetration, ok ? "held" : "NOT HELD:" + why);
    json["cases"].push_back(ToJson(c, run));
    held += ok;
    ++total;
    steps += run.done;
    tunnelled += run.tunnelled;
    nonfinite += run.nonfinite;
    penetration = std::max(penetration, run.penetration);
  }
  const long asked = static_cast<long>(cases.size());
  json["held"] = held;
  json["total"] = asked;
  json["steps"] = steps;
  json["tunnelled"] = tunnelled;
  json["nonfinite"] = nonfinite;
  json["penetration_um"] = 1e6 * penetration;
  fmt::print(stderr,
             "{} of {} cases held over {} steps: {} tunnelled, {} not finite, deepest overlap "
             "{:.3f} um\n",
             held, asked, steps, tunnelled, nonfinite, 1e6 * penetration);
  if (!options.json.empty()) WriteJson(options.json, json);
  if (held < asked) {
    throw Error(total < asked ? fmt::format("stability: only {} of {} cases were run", total, asked)
                              : fmt::format("stability: {} cases did not hold", asked - held));
  }
}

}  // namespace

void AddStability(const CommandLine& app) {
  auto options = std::make_shared<StabilityOptions>();
  const CommandLine command = app.AddCommand(
      "stability",
      "hard cases, each with a physical bound\n"
      "In every case, no body may tunnel, all numbers must be finite, and the overlap\n"
      "must not exceed 10 um if a pose without overlap exists.  Exit status 1 if a case\n"
      "fails.");
  command.Footer("Example: palpate-bench stability --steps 10000000 --json stability.json");
  Add(command, "--case", options->only, "run only this case (see --list)");
  command.AddFlag("--list", options->list, "list the cases with their bounds and reasons");
  Add(command, "--steps", options->steps, "approximate number of steps of all cases together")
      .Positive();
  options->features.AddTo(command);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
