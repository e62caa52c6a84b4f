#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/program/command_line.h"

namespace palpate {
struct TreeSource;
}

namespace palpate::bench {

/// An option of a command, with its usual value in --help, unless that is none.
/// @param value  must outlive the app.  T: as CommandLine::Add, of several with commas between
/// them.
template <class T>
Option Add(const CommandLine& command, const char* name, T& value, const std::string& help = "") {
  const Option option = command.Add(name, value, help);
  bool none = false;
  if constexpr (requires { value.has_value(); }) none = !value;
  if constexpr (requires {
                  value.push_back({});
                  value.front();
                } &&
                !std::is_same_v<T, std::string>) {
    none = value.empty();
    option.Commas();
  }
  if (!none) option.ShowDefault();
  return option;
}

// What several commands have.
void AddJson(const CommandLine& command, std::string& file);
void AddModels(const CommandLine& command, std::string& folder);
void AddPathSteps(const CommandLine& command, std::optional<int>& steps);
void AddRepeats(const CommandLine& command, int& repeats);
/// --tree FILE.sph, --level and --unit, which bring a tree of the Sphere-Tree Construction Toolkit
/// beside ours.
/// @param usual_unit  what the file's numbers mean where --unit is left out, for --help.
/// @returns --unit, for commands that have other files in it, or none.
Option AddTreeFile(const CommandLine& command, const char* usual_unit, TreeSource& source);

// Each adds its command to palpate-bench.
void AddAccuracy(const CommandLine& app);
void AddClosedLoop(const CommandLine& app);
void AddCut(const CommandLine& app);
void AddCycle(const CommandLine& app);
void AddHands(const CommandLine& app);
void AddLevels(const CommandLine& app);
/// `domain` is read when the command runs.
void AddLoop(const CommandLine& app, const int& domain);
void AddPareto(const CommandLine& app);
void AddPeers(const CommandLine& app);
void AddProbe(const CommandLine& app);
void AddQp(const CommandLine& app);
void AddStability(const CommandLine& app);
void AddTree(const CommandLine& app);

}  // namespace palpate::bench
