#pragma once

#include <map>
#include <string>

#include "common/json/json_file.h"

namespace palpate {

/// A text by language ("en", "de", "zh").  A plain string in a file is English.
using LocalText = std::map<std::string, std::string>;

/// Throws Error "file:line: field: what is wrong; remedy".
LocalText ReadLocalText(const JsonNode& node);
/// Returns the English text, else the first.
std::string EnglishOf(const LocalText& text);

}  // namespace palpate
