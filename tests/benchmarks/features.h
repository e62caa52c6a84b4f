#pragma once

#include <CLI/CLI.hpp>

#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {

/// Adds --contact and --friction to a command.
/// @param otherwise  what holds where they are left out, for --help.
void AddFeatureOptions(CLI::App& command, FeatureOverrides& features,
                       const std::string& otherwise = "as the scene says");

}  // namespace palpate::bench
