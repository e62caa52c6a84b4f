#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Text from outside as a part of one line: a control character (C0, DEL, C1), a mark that ends a
/// line or turns the direction of writing, a code of no character (which XML does not take), and a
/// byte that is no UTF-8 are written as escapes
/// ("\n", "\x1b", "\u0085"), so that nothing can pretend to be a line of ours.  What is printable
/// UTF-8 stays as it is.
std::string Printable(std::string_view text);

/// Its first characters, as many as fit into so many bytes.
std::string_view BeginningOf(std::string_view text, std::size_t most);

/// A printable text in quotes, shortened to 40 bytes: a name as a part of a message.
std::string Quoted(std::string_view text);

/// A word of a command that is printed to be copied into bash: as it is where no shell takes any of
/// it for more than a letter, else in quotes, and what is not printable as $'\x1b'.
std::string ShellWord(std::string_view word);

}  // namespace palpate
