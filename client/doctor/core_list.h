#pragma once

#include <set>
#include <string>

namespace palpate::doctor {

/// Cores as the kernel lists them: "2-3,6".  What is no number ("(null)", where there is none) is
/// left out.
std::set<int> ParseCores(const std::string& list);
std::string ToText(const std::set<int>& cores);

}  // namespace palpate::doctor
