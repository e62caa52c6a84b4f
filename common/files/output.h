#pragma once

#include <string>

namespace palpate {

/// Puts a program's result into a file, or on standard output where that is "-".  A file is whole
/// at any time: who reads it meanwhile has the former one.  Throws Error (file, remedy), and leaves
/// the former one.
/// @param option  that named the file, as "--json".
void WriteOutput(const std::string& option, const std::string& file, const std::string& text);

/// Throws what WriteOutput would, before the work that the result comes from.  What the file holds
/// stays; a file that was not there is, empty.
void CheckOutput(const std::string& option, const std::string& file);

}  // namespace palpate
