#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace palpate {

/// More splits than this are not made: longer numbers would look like dates.
inline constexpr std::size_t kMostSplits = 100'000;

/// The name of a recording's split: day.mcap's are day_000.mcap, ..., day_999.mcap, day_1000.mcap.
/// @param number  below kMostSplits.
std::string SplitName(const std::string& file, std::size_t number);

/// The files that have a name that SplitName gives for this recording, by number.  Whatever is in
/// them.
struct NamedSplit {
  std::string file;
  std::size_t number;
};
std::vector<NamedSplit> FindSplits(const std::string& file);

/// Throws Error where a new recording may not take this file's place: it is there, and has nothing
/// in it that says that palpate-record made it.  An empty file, a pipe and a device hold nothing
/// that could be lost.
void CheckMayReplace(const std::string& file);

/// What a recording says of itself with its first record.
inline constexpr char kRecordingRecord[] = "palpate.recording";

}  // namespace palpate
