#pragma once

#include <string>

namespace palpate {

/// As text of one line.  Names come from elsewhere, and need not be UTF-8: what is none is
/// replaced.
/// @tparam Json  nlohmann::json, which is slow to compile and so in no header.
template <class Json>
std::string ToText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpate
