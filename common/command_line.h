#pragma once

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace palpate {

// What every program owes its user on the command line, in one place.

/// Adds --version, --domain and --log-level.
/// @param app          named for the program.
/// @param domain_help  what a domain is to it.   @param domain, log_level  defaults; must outlive
/// it.
void AddCommonOptions(CLI::App& app, const std::string& domain_help, int& domain,
                      std::string& log_level);

/// False where --help or --version was asked for, and is printed.  Throws UsageError (argument,
/// where to look).
bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

/// A program but for its name: what it throws is said on stderr, and its exit status is then 2 for
/// a UsageError, 1 for all else.
/// @param run  returns the exit status.
int RunProgram(const std::string& program, const std::function<int()>& run) noexcept;

}  // namespace palpate
