#include "common/recording/split_name.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/error.h"
#include "common/mcap/mcap_reader.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Returns the number in a split's name; nothing if SplitName gives no such name.
std::optional<std::size_t> NumberIn(const fs::path& split, const fs::path& recording) {
  const std::string name = split.filename().string();
  const std::string begin = recording.stem().string() + "_", end = recording.extension().string();
  if (name.size() <= begin.size() + end.size() || !name.starts_with(begin)) return std::nullopt;
  std::size_t number = 0;
  const auto [rest, error] =
      std::from_chars(name.data() + begin.size(), name.data() + name.size() - end.size(), number);
  if (error != std::errc() || number >= kMostSplits) return std::nullopt;
  const fs::path exact = SplitName(recording.string(), number);
  return exact.filename() == name ? std::optional(number) : std::nullopt;
}

/// Returns true if the file itself shows that palpate-record made it.
bool IsRecording(const std::string& file) {
  try {
    const mcap::MappedFile mapped(file);
    mcap::Reader reader(mapped.bytes(), file);
    // The metadata record precedes all messages.
    mcap::Message first;
    reader.Next(first);
    return std::ranges::find(reader.metadata(), kRecordingRecord, &mcap::Metadata::name) !=
           reader.metadata().end();
  } catch (const Error&) {
    return false;  // it cannot be read, or is no MCAP file
  }
}

}  // namespace

std::string SplitName(const std::string& file, std::size_t number) {
  fs::path path(file);
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%03zu", number);
  path.replace_filename(path.stem().string() + digits + path.extension().string());
  return path.string();
}

std::vector<NamedSplit> FindSplits(const std::string& file) {
  const fs::path path(file);
  std::vector<NamedSplit> found;
  std::error_code none;  // if the folder cannot be listed, the writer reports why
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (const auto number = NumberIn(entry.path(), path)) {
      found.push_back({entry.path().string(), *number});
    }
  }
  std::ranges::sort(found, {}, &NamedSplit::number);
  return found;
}

void CheckMayReplace(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status) || fs::is_fifo(status) || fs::is_character_file(status)) return;
  const bool is_file = fs::is_regular_file(status);
  if (is_file && fs::file_size(file, error) == 0 && !error) return;
  if (!is_file || !IsRecording(file)) {
    throw Error(file +
                ": is not a recording of palpate-record, so it is not overwritten; give another "
                "name, or move it away");
  }
}

}  // namespace palpate
