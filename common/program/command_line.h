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

// What a program takes on its command line: CLI11's, of which command_line.cpp alone reads the
// headers, for whoever reads them is compiled for five seconds more.

/// An option.  A handle: copies are of the same.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  bool given() const;  ///< once it is parsed

  Option Required() const;
  Option ShowDefault() const;  ///< in --help: what its variable holds now
  Option ShowDefault(const std::string& text) const;
  Option TypeName(const std::string& name) const;  ///< of its value, in --help
  Option Needs(Option other) const;
  Option Excludes(Option other) const;

  Option Range(int least, int most) const;
  Option Range(double least, double most) const;
  Option Range(std::size_t least, std::size_t most) const;
  Option Positive() const;
  Option NotNegative() const;
  Option OneOf(const std::vector<std::string>& words) const;
  Option ExistingFolder() const;
  /// @param complaint  of a value; empty where that is right.  Of several checks the last is first.
  Option Check(const std::function<std::string(const std::string&)>& complaint) const;
  Option Transform(const std::function<std::string(std::string)>& transform) const;

  // Of several values:
  Option Words(int count) const;  ///< just so many
  Option OneAtATime() const;      ///< each after the option's name
  Option Commas() const;          ///< between them

 private:
  CLI::Option* option_;
};

/// A command line, or that of one of its commands.  A handle: copies are of the same.
class CommandLine {
 public:
  /// @param examples  after the options, in --help.
  CommandLine(const std::string& about, const std::string& program,
              const std::string& examples = "");

  const std::string& name() const;
  bool given() const;  ///< of a command, once all is parsed

  /// @param name   "-o,--output", or without dashes what stands by its place.
  /// @param value  must outlive this.  T: a text or a number, an optional or a vector of them, as
  ///               command_line.cpp instantiates it.
  template <class T>
  Option Add(const std::string& name, T& value, const std::string& help = "") const;
  Option AddText(const std::string& name, const std::function<void(const std::string&)>& take,
                 const std::string& help) const;
  Option AddNumber(const std::string& name, const std::function<void(double)>& take,
                   const std::string& help) const;
  Option AddFlag(const std::string& name, bool& value, const std::string& help) const;
  Option Find(const std::string& name) const;

  CommandLine AddCommand(const std::string& name, const std::string& about) const;
  void RequireCommands(std::size_t least, std::size_t most) const;
  /// Options of the whole may stand behind a command.
  void Fallthrough() const;
  void Hide() const;  ///< a command, from --help
  void Footer(const std::string& text) const;
  /// What is done where a command is given; and before that.
  void Run(const std::function<void()>& run) const;
  void BeforeCommands(const std::function<void()>& run) const;

 private:
  friend void AddCommonOptions(const CommandLine& app, const std::string& domain_help, int& domain,
                               std::string& log_level);
  friend bool ParseCommandLine(const CommandLine& app, int argc, const char* const* argv);
  explicit CommandLine(std::shared_ptr<CLI::App> app);

  std::shared_ptr<CLI::App> app_;
};

// What every program owes its user on the command line, in one place.

/// Adds --version, --domain, --log-level and --log-format, which holds for SetUpLog at once.
/// @param app          named for the program.
/// @param domain_help  what a domain is to it.
/// @param domain, log_level  defaults; must outlive the app.
void AddCommonOptions(const CommandLine& app, const std::string& domain_help, int& domain,
                      std::string& log_level);

/// Adds --network and --peer, for a program that may meet others across a network.
/// @param peer  whose address --peer is: "the server".   @param network  must outlive the app.
void AddNetworkOptions(const CommandLine& app, const std::string& peer, dds::Network& network);

/// What a program is told that meets a server: a base of its options.
struct ServerOptions {
  int domain = 0;
  dds::Network network{};
  std::string log_level = "info";
};
/// Adds what AddCommonOptions and AddNetworkOptions do.   @param options  must outlive the app.
void AddServerOptions(const CommandLine& app, ServerOptions& options);

/// Adds --transport, for a program that is linked with common/dds.
/// @param transport  must outlive the app.
inline void AddTransportOption(const CommandLine& app, dds::Transport& transport) {
  app.AddText(
         "--transport",
         [&transport](const std::string& text) { transport = dds::ParseTransport(text); },
         "how poses and wrenches travel, as for the server: auto (shared memory if possible), shm "
         "or udp")
      .ShowDefault("auto");
}

/// Adds --realtime and --cpu, for a program with a loop.
/// @param loop  whose scheduling it is: "the servo loops".   @param realtime  must outlive the app.
void AddRealtimeOptions(const CommandLine& app, const std::string& loop, RealtimeOptions& realtime);

/// Adds --host-name, for a program that answers HTTP: names are then in small letters.
/// @param what  browsers ask for: "the page".   @param names  must outlive the app.
void AddHostNameOption(const CommandLine& app, const std::string& what,
                       std::vector<std::string>& names);

/// False where --help or --version was asked for, and is printed.  Numbers are finite then.  Throws
/// UsageError (argument, where to look).
bool ParseCommandLine(const CommandLine& app, int argc, const char* const* argv);

/// A program but for its name: what it throws is said on stderr, and its exit status is then 2 for
/// a UsageError, 1 for all else.
/// @param run  returns the exit status.
int RunProgram(const std::string& program, const std::function<int()>& run) noexcept;

/// A program with options, of which one is `log_level`.
/// @param parse  of the command line; nothing where no more is to be done.
/// @param run    does what they say, and returns the exit status.
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
