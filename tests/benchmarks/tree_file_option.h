#pragma once

#include <CLI/CLI.hpp>

#include "scenes/tree/tree_source.h"

namespace palpate::bench {

/// Adds --tree FILE.sph, --level and --unit, which bring a tree of the Sphere-Tree Construction
/// Toolkit beside ours.
/// @param usual_unit  what the file's numbers mean where --unit is left out, for --help.
/// @returns --unit, for commands that have other files in it, or none.
CLI::Option* AddTreeFileOptions(CLI::App& command, const char* usual_unit, TreeSource& source);

}  // namespace palpate::bench
