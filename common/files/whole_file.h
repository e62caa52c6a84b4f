#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

struct stat;

namespace palpate {

/// A further check of a file before it is read, such as its owner and rights.  It examines the
/// open file, so the name cannot be redirected between check and reading.  Throws Error if the
/// check fails.
using FileCheck = std::function<void(const struct stat& status)>;

/// Opens a regular file for reading, without ever blocking on it.  Refuses folders, pipes, sockets
/// and devices, because these may have no end, or have effects when opened.
/// @param most  greatest size [bytes]; a larger file is refused.
/// @param flag  the one that named the file, for the message: "--tokens"; empty: none.
/// Returns a file descriptor, which the caller must close.  Throws Error (file, fault, remedy).
/// Not real-time: it accesses the disk.
int OpenRegularFile(const std::string& file, std::uint64_t most, const std::string& flag = "",
                    const FileCheck& check = {});

/// Returns the whole contents of a regular file.  Every caller gives the limit for its kind of
/// file, so that no file name, wherever it came from, can exhaust the memory.  Also reads files in
/// /proc and /sys, whose size is not known in advance.
/// Parameters and errors are those of OpenRegularFile; a file that grows beyond `most` is
/// refused, too.
std::string ReadWholeFile(const std::string& file, std::uint64_t most, const std::string& flag = "",
                          const FileCheck& check = {});

/// As OpenRegularFile and ReadWholeFile, for a file below a folder that a program keeps, in which
/// somebody may have put links: neither the file nor a folder on the way from `folder` to it may
/// be one.
/// @param file  its path, which begins with `folder`.
int OpenFileBelow(const std::string& folder, const std::string& file, std::uint64_t most,
                  const FileCheck& check = {});
std::string ReadFileBelow(const std::string& folder, const std::string& file, std::uint64_t most,
                          const FileCheck& check = {});
/// Throws Error if one of the folders on the way from `folder` to `below` is a link or is missing.
void RefuseLinks(const std::string& folder, const std::string& below);

/// Returns the whole contents of a file that need not exist; nothing if it cannot be read for
/// any reason.
std::optional<std::string> TryReadWholeFile(const std::string& file, std::uint64_t most);

}  // namespace palpate
