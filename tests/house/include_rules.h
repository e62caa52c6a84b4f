#pragma once

#include <functional>
#include <string>
#include <vector>

namespace palpate::house {

/// Checks the include lines of one source file against who may include whom (the table is in the
/// .cpp, with its reasons) and against the spelling from the root.
/// @param path    relative to the root, as "server/physics/qp_solver.cpp".
/// @param text    what the file holds.
/// @param exists  whether a path, relative to the root, is a file of the project.
/// Returns one line for each violation, "path:line: what is wrong and what would be right".
std::vector<std::string> IncludeViolations(const std::string& path, const std::string& text,
                                           const std::function<bool(const std::string&)>& exists);

}  // namespace palpate::house
