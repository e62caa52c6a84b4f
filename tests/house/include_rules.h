#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace palpate::house {

/// Checks the include lines of one source file: who may include whom (the table is in the .cpp,
/// with its reasons), the order of the floors of server/physics, and the spelling from the root.
/// @param path    relative to the root, as "server/physics/qp_solver.cpp".
/// @param text    content of the file.
/// @param exists  whether a path, relative to the root, is a file of the project.
/// Returns one line for each violation, "path:line: what is wrong and what would be right".
std::vector<std::string> IncludeViolations(const std::string& path, const std::string& text,
                                           const std::function<bool(const std::string&)>& exists);

/// The files of the project that a file includes, as its text spells them.
std::vector<std::string> ProjectIncludes(const std::string& text);

/// Files that include each other in a circle, with the first one again at the end; empty: there is
/// none.
std::vector<std::string> IncludeCircle(
    const std::map<std::string, std::vector<std::string>>& includes);

}  // namespace palpate::house
