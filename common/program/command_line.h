#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/dds/network.h"
#include "common/program/log.h"
#include "common/program/realtime.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI
namespace palpate::dds {
enum class Transport;
Transport ParseTransport(const std::string& text);
}  // namespace palpate::dds

namespace palpate {

// The command line of a program: a wrapper of CLI11, whose headers are included by command_line.cpp
// alone, because they add five seconds to the compilation of each file that includes them.  Not as
// precompiled headers, either: CLI11 2.1 instantiates its validators in every source that sees it,
// 2.5 s each even where it uses nothing, and saves a source that uses it only 1 s.

/// A handle of an option: copies refer to the same one.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  bool given() const;  ///< valid after parsing

  Option Required() const;
  Option ShowDefault() const;  ///< shows the variable's present value in --help
  Option ShowDefault(const std::string& text) const;
  Option TypeName(const std::string& name) const;  ///< name of the value's type in --help
  Option Needs(Option other) const;
  Option Excludes(Option other) const;

  Option Range(int least, int most) const;
  Option Range(double least, double most) const;
  Option Range(std::size_t least, std::size_t most) const;
  Option Positive() const;
  Option NotNegative() const;
  Option OneOf(const std::vector<std::string>& words) const;
  Option ExistingFolder() const;
  /// @param complaint  returns the complaint about a value; empty if it is valid.  Of several
  /// checks, the one added last runs first.
  Option Check(const std::function<std::string(const std::string&)>& complaint) const;
  Option Transform(const std::function<std::string(std::string)>& transform) const;

  // For options with several values:
  Option Words(int count) const;  ///< exactly `count` values
  Option OneAtATime() const;      ///< the option's name stands before each value
  Option Commas() const;          ///< values are separated by commas

 private:
  CLI::Option* option_;
};

/// A handle of a program's command line, or of one of its commands: copies refer to the same one.
class CommandLine {
 public:
  /// @param about     its first line is a summary; lines have at most 80 characters.
  /// @param examples  shown after the options in --help; likewise.
  CommandLine(const std::string& about, const std::string& program,
              const std::string& examples = "");

  const std::string& name() const;
  bool given() const;  ///< for a command; valid after parsing

  /// @param name   "-o,--output", or without dashes for a positional argument.
  /// @param value  must outlive this.  T is a string, a number, or an optional or a vector of
  /// these; command_line.cpp instantiates it.
  template <class T>
  Option Add(const std::string& name, T& value, const std::string& help = "") const;
  Option AddText(const std::string& name, const std::function<void(const std::string&)>& take,
                 const std::string& help) const;
  Option AddNumber(const std::string& name, const std::function<void(double)>& take,
                   const std::string& help) const;
  Option AddFlag(const std::string& name, bool& value, const std::string& help) const;
  Option Find(const std::string& name) const;

  /// @param about  its first line is a summary, which the program's own --help shows.
  CommandLine AddCommand(const std::string& name, const std::string& about) const;
  void RequireCommands(std::size_t least, std::size_t most) const;
  /// Allows the program's options after a command, too.
  void Fallthrough() const;
  void Hide() const;  ///< hides a command in --help
  void Footer(const std::string& text) const;
  /// Run: sets the action of a command.  BeforeCommands: sets what is done before any command.
  void Run(const std::function<void()>& run) const;
  void BeforeCommands(const std::function<void()>& run) const;

 private:
  friend void AddCommonOptions(const CommandLine& app, const std::string& domain_help, int& domain,
                               std::string& log_level);
  friend bool ParseCommandLine(const CommandLine& app, int argc, const char* const* argv);
  explicit CommandLine(std::shared_ptr<CLI::App> app);

  std::shared_ptr<CLI::App> app_;
};

// The options that programs have in common.

/// Adds --version, --domain, --log-level and --log-format, which takes effect when it is parsed.
/// @param app          has the program's name.
/// @param domain_help  help text: what a domain is to the program.
/// @param domain, log_level  defaults; must outlive the app.
void AddCommonOptions(const CommandLine& app, const std::string& domain_help, int& domain,
                      std::string& log_level);

/// Adds --network and --peer, for a program that may communicate across a network.
/// @param peer  whose address --peer is: "the server".
/// @param network  must outlive the app.
void AddNetworkOptions(const CommandLine& app, const std::string& peer, dds::Network& network);

/// The options of a program that connects to a server; a base of its own options.
struct ServerOptions {
  int domain = 0;
  dds::Network network{};
  std::string log_level = "info";
};
/// Adds what AddCommonOptions and AddNetworkOptions add.
/// @param options  must outlive the app.
void AddServerOptions(const CommandLine& app, ServerOptions& options);

/// Adds --transport, for a program that links common/dds.
/// @param transport  must outlive the app.
inline void AddTransportOption(const CommandLine& app, dds::Transport& transport) {
  app.AddText(
         "--transport",
         [&transport](const std::string& text) { transport = dds::ParseTransport(text); },
         "transport of poses and wrenches: auto (shared memory if available, else UDP), shm or udp")
      .ShowDefault("auto");
}

/// Adds --realtime and --cpu, for a program with a loop.
/// @param loop  what is scheduled: "the servo loops".
/// @param realtime  must outlive the app.
void AddRealtimeOptions(const CommandLine& app, const std::string& loop, RealtimeOptions& realtime);

/// Adds --effects, which adds a folder to $PALPATE_EFFECTS, for a program that loads scenes: so
/// scenes that it loads by whatever way, and programs that it starts, may run the effects there.
void AddEffectsOption(const CommandLine& app);

/// Adds --host-name, for a program that serves HTTP.  The names are converted to lower case.
/// @param what  what browsers request: "the page".
/// @param names  must outlive the app.
void AddHostNameOption(const CommandLine& app, const std::string& what,
                       std::vector<std::string>& names);

/// Parses the command line; false if --help or --version was given, which it then prints.  All
/// numbers are checked to be finite.  Throws UsageError (argument, where to find help).
bool ParseCommandLine(const CommandLine& app, int argc, const char* const* argv);

/// Runs a program: prints any exception on stderr and returns the exit status, 2 for a UsageError,
/// 1 for any other exception.
/// @param run  returns the exit status.
int RunProgram(const std::string& program, const std::function<int()>& run) noexcept;

/// Runs a program whose options have a member `log_level`.
/// @param parse  parses the command line; returns nothing if there is nothing more to do.
/// @param run    does the work and returns the exit status.
template <class Parse, class Run>
int RunProgram(const std::string& program, int argc, char** argv, Parse parse, Run run) noexcept {
  return RunProgram(program, [&] {
    const auto options = parse(argc, argv);
    if (!options) return 0;
    SetUpLog(program, options->log_level);
    return run(*options);
  });
}

}  // namespace palpate
