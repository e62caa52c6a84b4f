#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Text from outside as a part of one line: a control character (C0, DEL, C1), a mark that ends a
/// line or turns the direction of writing, and a byte that is no UTF-8 are written as escapes
/// ("\n", "\x1b", "\u0085"), so that nothing can pretend to be a line of ours.  What is printable
/// UTF-8 stays as it is.
std::string Printable(std::string_view text);

/// The same in quotes, shortened to 40 bytes: a name as a part of a message.
std::string Quoted(std::string_view text);

}  // namespace palpate
