#pragma once

#include <string>

namespace palpate {

enum class Links { kFollow, kReplace };

/// Writes a program's result to a file, or to standard output if the name is "-".  The file is
/// replaced atomically: a concurrent reader sees the old one or the new one, complete.  Throws
/// Error (file, remedy), and then leaves the old file unchanged.
/// @param option  the one that named the file: "--json".
/// @param links  whether a link of that name is written through, as somebody who names a file may
/// want, or replaced, as in a folder that a program keeps.
void WriteOutput(const std::string& option, const std::string& file, const std::string& text,
                 Links links = Links::kFollow);

/// Throws what WriteOutput would throw, before the work whose result is to be written.  An existing
/// file keeps its contents; a missing one is created empty.
void CheckOutput(const std::string& option, const std::string& file);

}  // namespace palpate
