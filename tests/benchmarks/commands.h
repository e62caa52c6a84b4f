#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/program/command_line.h"

namespace palpate::bench {

/// Adds an option to a command, and shows its default in --help unless that is empty.
/// @param value  must outlive the app.  T: see CommandLine::Add; commas separate several values.
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

// Options of several commands.
void AddJson(const CommandLine& command, std::string& file);
void AddModels(const CommandLine& command, std::string& folder);
void AddPathSteps(const CommandLine& command, std::optional<int>& steps);
void AddRepeats(const CommandLine& command, int& repeats);
/// Reads the value A..B of an option --seeds.  Throws UsageError if it is none.
std::pair<std::uint64_t, std::uint64_t> SeedRange(const std::string& text);

void AddAccuracy(const CommandLine& app);
void AddClosedLoop(const CommandLine& app);
void AddCut(const CommandLine& app);
void AddCycle(const CommandLine& app);
void AddHands(const CommandLine& app);
/// `domain` is read when the command runs.
void AddLoop(const CommandLine& app, const int& domain);
void AddPareto(const CommandLine& app);
void AddPeers(const CommandLine& app);
void AddQp(const CommandLine& app);
void AddStability(const CommandLine& app);
void AddTree(const CommandLine& app);
void AddTruth(const CommandLine& app);

}  // namespace palpate::bench
