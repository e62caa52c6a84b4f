#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/dds/network.h"
#include "common/program/realtime.h"

namespace CLI {
class App;
}

namespace palpate {

// What every program owes its user on the command line, in one place.

/// Adds --version, --domain, --log-level and --log-format, which holds for SetUpLog at once.
/// @param app          named for the program.
/// @param domain_help  what a domain is to it.
/// @param domain, log_level  defaults; must outlive the app.
void AddCommonOptions(CLI::App& app, const std::string& domain_help, int& domain,
                      std::string& log_level);

/// Adds --network and --peer, for a program that may meet others across a network.
/// @param peer  whose address --peer is: "the server".   @param network  must outlive the app.
void AddNetworkOptions(CLI::App& app, const std::string& peer, dds::Network& network);

/// Adds --realtime and --cpu, for a program with a loop.
/// @param loop  whose scheduling it is: "the servo loops".   @param realtime  must outlive the app.
void AddRealtimeOptions(CLI::App& app, const std::string& loop, RealtimeOptions& realtime);

/// False where --help or --version was asked for, and is printed.  Numbers are finite then.  Throws
/// UsageError (argument, where to look).
bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

/// A program but for its name: what it throws is said on stderr, and its exit status is then 2 for
/// a UsageError, 1 for all else.
/// @param run  returns the exit status.
int RunProgram(const std::string& program, const std::function<int()>& run) noexcept;

}  // namespace palpate
