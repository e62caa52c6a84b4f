#pragma once

#include <CLI/CLI.hpp>

namespace palpate::bench {

// Each adds its command to palpate-bench; the callback runs when the command was given.
void AddAccuracy(CLI::App& app);
void AddClosedLoop(CLI::App& app);
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
