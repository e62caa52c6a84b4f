#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Returns external text made safe as a part of one line, so that it cannot imitate a line of ours.
/// Control characters (C0, DEL, C1), characters that end a line or change the direction of writing,
/// code points that are no characters (which XML rejects) and bytes that are not UTF-8 become
/// escapes (backslash-n, "\x1b", "\u0085"); printable UTF-8 stays as it is.
std::string Printable(std::string_view text);

/// Returns the first characters of a text, as many as fit into `most` bytes.
std::string_view BeginningOf(std::string_view text, std::size_t most);

/// Returns a text made Printable, in quotes and shortened to 40 bytes: for a name in a message.
std::string Quoted(std::string_view text);

/// Returns a word of a command that users can copy into bash: unchanged if no character in it is
/// special to a shell, else quoted, with unprintable characters as $'\x1b'.
std::string ShellWord(std::string_view word);

}  // namespace palpate
