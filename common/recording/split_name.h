#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace palpate {

/// Limit on the number of splits: longer numbers would look like dates.
inline constexpr std::size_t kMostSplits = 100'000;

/// Returns the name of a recording's split: for day.mcap day_000.mcap, ...,
/// day_999.mcap, day_1000.mcap.
/// @param number  below kMostSplits.
std::string SplitName(const std::string& file, std::size_t number);

/// A file whose name SplitName could have given, whatever it contains.  FindSplits returns those of
/// a recording, ordered by number.
struct NamedSplit {
  std::string file;
  std::size_t number;
};
std::vector<NamedSplit> FindSplits(const std::string& file);

/// Throws Error if a new recording must not replace this file: it exists, and nothing in it
/// shows that palpate-record made it.  An empty file, a pipe or a device may be replaced:
/// nothing is lost.
void CheckMayReplace(const std::string& file);

/// Name of the metadata record with which every recording begins.
inline constexpr char kRecordingRecord[] = "palpate.recording";

}  // namespace palpate
