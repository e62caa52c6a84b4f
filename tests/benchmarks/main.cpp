#include <cstdio>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/log.h"
#include "tests/benchmarks/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Measurements of Palpate: each command prints a table, and JSON with --json FILE.",
               "palpate-bench");
  app.set_version_flag("--version", std::string("palpate-bench ") + PALPATE_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  int domain = palpate::dds::kMaxDomain;
  std::string log_level = "info";
  app.add_option("--domain", domain, "DDS domain of loop: one that nothing else uses")
      ->check(CLI::Range(0, palpate::dds::kMaxDomain))
      ->capture_default_str();
  app.add_option("--log-level", log_level, "trace, debug, info, warn, error or off");
  app.parse_complete_callback([&] { palpate::SetUpLog("palpate-bench", log_level); });
  palpate::bench::AddAccuracy(app);
  palpate::bench::AddClosedLoop(app);
  palpate::bench::AddCycle(app);
  palpate::bench::AddLevels(app);
  palpate::bench::AddLimiter(app);
  palpate::bench::AddLoop(app, domain);
  palpate::bench::AddPareto(app);
  palpate::bench::AddQp(app);
  palpate::bench::AddStability(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const palpate::UsageError& error) {
    std::fprintf(stderr, "palpate-bench: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate-bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
