
#include "common/dds/topics.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "tests/benchmarks/commands.h"

namespace palpate::bench {
namespace {

int Main(int argc, char** argv) {
  const CommandLine app(
      "Measures Palpate: each command prints a table, and writes JSON with --json FILE.\n"
      "pareto and peers write a report, CSV and JSON to their --out folder.",
      "palpate-bench",
      "Example: palpate-bench cycle --scene bunny-bunny --json -\n"
      "'palpate-bench COMMAND --help' explains a command.");
  app.RequireCommands(1, 1);
  app.Fallthrough();
  int domain = dds::kMaxDomain;
  std::string log_level = "info";
  AddEffectsOption(app);
  AddCommonOptions(app, "number of the DDS domain of loop; no other program may use it", domain,
                   log_level);
  // Before the commands' callbacks, which run them.
  app.BeforeCommands([&] { SetUpLog("palpate-bench", log_level); });
  AddAccuracy(app);
  AddClosedLoop(app);
  AddCut(app);
  AddCycle(app);
  AddHands(app);
  AddLoop(app, domain);
  AddPareto(app);
  AddPeers(app);
  AddQp(app);
  AddStability(app);
  AddTree(app);
  AddTruth(app);
  ParseCommandLine(app, argc, argv);
  return 0;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-bench", [&] { return palpate::bench::Main(argc, argv); });
}
