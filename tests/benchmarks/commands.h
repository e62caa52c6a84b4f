#pragma once

#include <CLI/CLI.hpp>

namespace palpate::bench {

// Each adds its command to palpate-bench; the callback runs when the command was given.
void AddCycle(CLI::App& app);
void AddLoop(CLI::App& app);
void AddQp(CLI::App& app);

}  // namespace palpate::bench
