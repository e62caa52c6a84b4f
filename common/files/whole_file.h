#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

struct stat;

namespace palpate {

/// What else has to be true of a file before it is read: its owner, its rights.  Looks at the file
/// that is open, which is the one that is read whatever its name comes to mean meanwhile; throws
/// Error where it is not as it should be.
using FileCheck = std::function<void(const struct stat& status)>;

/// Opens a regular file to read it, and never waits for it: a folder, a pipe, a socket and a device
/// are refused, for those have no end, or act when they are opened.
/// @param most  bytes; a larger file is refused.
/// @param flag  that named the file, as "--tokens", for the message; empty: none did.
/// Returns a descriptor that is the caller's to close.  Throws Error: the file, what is wrong with
/// it and the remedy.  Not for a servo loop: it asks the disk.
int OpenRegularFile(const std::string& file, std::uint64_t most, const std::string& flag = "",
                    const FileCheck& check = {});

/// All that a regular file holds.  Every reader gives the limit that its own kind of file has, so
/// that no name of a file, however it came about, takes all memory.  Also reads what the kernel
/// tells in /proc and /sys, where a file's size is not known before.
/// Parameters and errors are OpenRegularFile's; one that grows beyond `most` is refused, too.
std::string ReadWholeFile(const std::string& file, std::uint64_t most, const std::string& flag = "",
                          const FileCheck& check = {});

/// The same for a file that need not be there: nothing, for whatever reason it cannot be read.
std::optional<std::string> TryReadWholeFile(const std::string& file, std::uint64_t most);

}  // namespace palpate
