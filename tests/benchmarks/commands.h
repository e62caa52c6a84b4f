#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace palpate {
struct TreeSource;
}

namespace palpate::bench {

/// An option of a command, with its usual value in --help, unless that is none.
/// T: std::string, int, long, std::uint64_t, double, an optional or, with commas between them,
/// several of these.
/// @param value  must outlive the app.
template <class T>
CLI::Option* Add(CLI::App& command, const char* name, T& value, const std::string& help = "");

// What several commands have.
void AddJson(CLI::App& command, std::string& file);
void AddModels(CLI::App& command, std::string& folder);
void AddPathSteps(CLI::App& command, std::optional<int>& steps);
void AddRepeats(CLI::App& command, int& repeats);
void AddTransport(CLI::App& command, std::string& transport);
/// --tree FILE.sph, --level and --unit, which bring a tree of the Sphere-Tree Construction Toolkit
/// beside ours.
/// @param usual_unit  what the file's numbers mean where --unit is left out, for --help.
/// @returns --unit, for commands that have other files in it, or none.
CLI::Option* AddTreeFile(CLI::App& command, const char* usual_unit, TreeSource& source);

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
