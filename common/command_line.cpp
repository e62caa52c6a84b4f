#include "common/command_line.h"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate {

void AddCommonOptions(CLI::App& app, const std::string& domain_help, int& domain,
                      std::string& log_level) {
  app.set_version_flag("--version", app.get_name() + " " PALPATE_VERSION);
  app.add_option("--domain", domain, domain_help)
      ->check(CLI::Range(0, dds::kMaxDomain))
      ->capture_default_str();
  app.add_option("--log-level", log_level, "trace, debug, info, warn, error or off")
      ->capture_default_str();
}

bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    app.exit(wanted);  // prints the help or the version
    return false;
  } catch (const CLI::ParseError& error) {
    throw UsageError(std::string(error.what()) + "; '" + app.get_name() + " --help' shows how");
  }
  return true;
}

int RunProgram(const std::string& program, const std::function<int()>& run) noexcept {
  const auto fail = [&](const std::exception& error, int status) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return status;
  };
  try {
    return run();
  } catch (const UsageError& error) {
    return fail(error, 2);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
}

}  // namespace palpate
