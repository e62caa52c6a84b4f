#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// What a client has sent, as a part of a message or of the log: in quotes, shortened to 40 bytes,
/// without control characters, which could pretend to be a line of ours.
std::string Quoted(std::string_view text);

}  // namespace palpate
