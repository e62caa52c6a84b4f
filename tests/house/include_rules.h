#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace palpate::house {

/// Checks the include lines of one source file against who may include whom (the table is in the
/// .cpp, with its reasons), against the order of the floors of server/physics, and against the
/// spelling from the root.
/// @param path    relative to the root, as "server/physics/qp_solver.cpp".
/// @param text    what the file holds.
/// @param exists  whether a path, relative to the root, is a file of the project.
/// Returns one line for each violation, "path:line: what is wrong and what would be right".
std::vector<std::string> IncludeViolations(const std::string& path, const std::string& text,
                                           const std::function<bool(const std::string&)>& exists);

/// The files of the project that a file includes, as its text spells them.
std::vector<std::string> ProjectIncludes(const std::string& text);

/// Files that include each other in a circle, the first one again at the end; empty where there is
/// none.
std::vector<std::string> IncludeCircle(
    const std::map<std::string, std::vector<std::string>>& includes);

}  // namespace palpate::house
