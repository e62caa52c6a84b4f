#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace palpate {
struct TreeSource;
}

namespace palpate::bench {

/// What is asked of an option's value; each returns the option itself.
class CommandOption {
 public:
  CommandOption(CLI::App& command, CLI::Option& option) : command_(command), option_(option) {}
  CommandOption& Positive();
  CommandOption& NonNegative();
  template <class T>
  CommandOption& Within(T least, T most);
  CommandOption& OneOf(std::vector<std::string> values);
  CommandOption& ExistingFolder();
  CommandOption& Required();
  /// @param other  an option of the command that was added before.
  CommandOption& Needs(const char* other);
  CommandOption& Excludes(const char* other);

 private:
  CLI::App& command_;
  CLI::Option& option_;
};

/// A command of palpate-bench.  CLI11 is behind it: reading its headers takes a compiler longer
/// than reading the rest of a command.
class Command {
 public:
  Command(CLI::App& app, const std::string& name, const std::string& what);
  /// @param run  runs when the command was given, after all its options have their values.
  void Runs(std::function<void()> run);
  void Hide();

  /// T: std::string, int, long, std::uint64_t, double, an optional or, with commas between them,
  /// several of these.  --help shows the value that is there, unless it is none.
  /// @param value  must outlive the app.
  template <class T>
  CommandOption Add(const char* name, T& value, const std::string& help = "");
  CommandOption AddFunction(const char* name, std::function<void(const std::string&)> set,
                            const std::string& help);
  void AddFlag(const char* name, bool& value, const std::string& help);

  // What several commands have.
  void AddJson(std::string& file);
  void AddModels(std::string& folder);
  void AddPathSteps(std::optional<int>& steps);
  void AddRepeats(int& repeats);
  void AddTransport(std::string& transport);
  /// --tree FILE.sph, --level and --unit, which bring a tree of the Sphere-Tree Construction
  /// Toolkit beside ours.
  /// @param usual_unit  what the file's numbers mean where --unit is left out, for --help.
  /// @returns --unit, for commands that have other files in it, or none.
  CommandOption AddTreeFile(const char* usual_unit, TreeSource& source);

 private:
  CLI::App& app_;
};

// Each adds its command to palpate-bench.
void AddAccuracy(CLI::App& app);
void AddClosedLoop(CLI::App& app);
void AddCut(CLI::App& app);
void AddCycle(CLI::App& app);
/// `domain` is read when the command runs.
void AddDeadServer(CLI::App& app, const int& domain);
void AddHands(CLI::App& app);
void AddLevels(CLI::App& app);
void AddLimiter(CLI::App& app);
/// As there.
void AddLoop(CLI::App& app, const int& domain);
void AddPareto(CLI::App& app);
void AddQp(CLI::App& app);
void AddStability(CLI::App& app);
void AddTree(CLI::App& app);

}  // namespace palpate::bench
