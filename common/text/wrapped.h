#pragma once

#include <string>
#include <vector>

namespace palpate {

/// Returns lines of at most `width` bytes, broken at spaces; keeps a longer word (a path) whole.
std::vector<std::string> Wrapped(const std::string& text, int width);

}  // namespace palpate
