#include "client/replayer/export/export_folder.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/export/methods.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/files/output.h"
#include "common/files/whole_file.h"
#include "common/mcap/mcap_reader.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Of the file that names those of an export: some hundred thousand names.
constexpr std::uint64_t kMostMethodsBytes = std::uint64_t{16} << 20;

constexpr const char* kMethodsFile = "methods.json";

using Made = ExportFolder::Made;

std::string HashOf(std::span<const std::uint8_t> bytes) {
  return Hex16(BundleHash(bytes));
}
std::string HashOf(std::string_view text) {
  return HashOf({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

// methods.json ends with its own hash, as it is without it, and so knows whether it was changed.
constexpr std::string_view kHashKey = ",\n  \"hash\": \"", kHashEnd = "\"", kJsonEnd = "\n}\n";

std::string WithHash(const std::string& json) {
  return fmt::format("{}{}{}{}{}", json.substr(0, json.size() - kJsonEnd.size()), kHashKey,
                     HashOf(json), kHashEnd, kJsonEnd);
}
bool IsAsWritten(const std::string& json) {
  const std::size_t key = json.rfind(kHashKey);
  return key != std::string::npos && WithHash(json.substr(0, key) + std::string(kJsonEnd)) == json;
}

/// Of a former export; none where the folder holds none, or somebody has changed what it says.
std::optional<Made> MadeIn(const fs::path& folder) {
  const auto text = TryReadWholeFile(folder / kMethodsFile, kMostMethodsBytes);
  if (!text || !IsAsWritten(*text)) return std::nullopt;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("made_by") || json["made_by"] != kExportMark ||
      !json.contains("hashes")) {
    return std::nullopt;
  }
  Made made{{kMethodsFile, HashOf(*text)}};
  for (const auto& [file, hash] : json["hashes"].items()) made[file] = hash.get<std::string>();
  return made;
}

/// What is in a folder, each before what is in it.
std::vector<fs::path> AllIn(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) all.push_back(entry.path());
  return all;
}

bool IsAsMade(const fs::path& path, const fs::path& folder, const Made& made) {
  const std::string name = path.lexically_relative(folder).string();
  const fs::file_status status = fs::symlink_status(path);
  if (fs::is_directory(status)) {
    const auto first = made.lower_bound(name + "/");
    return first != made.end() && first->first.starts_with(name + "/");
  }
  const auto file = made.find(name);
  if (file == made.end() || !fs::is_regular_file(status)) return false;
  try {
    return HashOf(mcap::MappedFile(path.string()).bytes()) == file->second;
  } catch (const Error&) {
    return false;  // nobody can tell
  }
}

/// Throws Error where something in the folder is not, or no longer, what the export has made.
/// @param remedy  what to do about it.
void CheckIsAsMade(const fs::path& folder, const Made& made, const std::string& remedy) {
  for (const fs::path& path : AllIn(folder)) {
    if (IsAsMade(path, folder, made)) continue;
    throw Error("-o " + folder.string() + ": holds " +
                Quoted(path.lexically_relative(folder).string()) +
                ", which no export made, or which was changed since; " + remedy);
  }
}

/// Files that are as they were made; then the folders, which the system removes only where they are
/// empty.
void RemoveMade(const fs::path& folder, const Made& made) {
  std::vector<fs::path> all = AllIn(folder);
  std::ranges::reverse(all);
  all.push_back(folder);
  std::error_code ignored;
  for (const fs::path& path : all) {
    if (path == folder || IsAsMade(path, folder, made)) fs::remove(path, ignored);
  }
}

/// Throws Error where the folder may not give way to a new export; else what a former one made.
Made CheckMayMake(const std::string& name, bool overwrite) {
  const fs::path folder = name;
  if (!fs::exists(fs::symlink_status(folder))) return {};
  if (!fs::is_directory(fs::symlink_status(folder))) {
    throw Error("-o " + name + ": is there already and is no folder; give another name");
  }
  if (fs::is_empty(folder)) return {};
  if (!overwrite) {
    throw Error("-o " + name +
                ": is there already; give another name, or --overwrite for a former export");
  }
  const auto made = MadeIn(folder);
  if (!made) {
    throw Error("-o " + name + ": has no " + kMethodsFile +
                " as an export of this version has written it, and so is not overwritten; give "
                "another name");
  }
  CheckIsAsMade(folder, *made, "move it away, or give another name");
  return *made;
}

}  // namespace

ExportFolder::ExportFolder(const std::string& folder, bool overwrite)
    : name_(folder), former_(CheckMayMake(folder, overwrite)) {
  while (name_.has_relative_path() && !name_.has_filename()) name_ = name_.parent_path();
  part_ = name_;
  part_ += ".part";
  std::error_code problem;
  if (name_.has_parent_path()) fs::create_directories(name_.parent_path(), problem);
  if (!fs::create_directory(part_, problem)) {
    throw Error(part_.string() +
                (problem ? ": cannot be made (" + problem.message() + "); give another folder"
                         : ": is there already, of an export that was killed or is at work; "
                           "remove it, or give another name"));
  }
  made_.push_back(part_);
}

ExportFolder::~ExportFolder() {
  std::error_code ignored;
  std::ranges::reverse(made_);
  // Of folders, only those that are empty.
  for (const fs::path& path : made_) fs::remove(path, ignored);
}

Made ExportFolder::HashesOf(const std::vector<std::string>& files) const {
  Made hashes;
  for (const std::string& file : files) {
    hashes[file] = HashOf(mcap::MappedFile((part_ / file).string()).bytes());
  }
  return hashes;
}

void ExportFolder::Finish(const std::string& methods) {
  WriteOutput("-o", Make(part_ / kMethodsFile).string(), WithHash(methods));
  made_.clear();
  const std::string remedy =
      "the new export is whole in " + part_.string() + ": move one of the two";
  if (!former_.empty()) {
    CheckIsAsMade(name_, former_, remedy);
    RemoveMade(name_, former_);
  }
  std::error_code problem;
  fs::rename(part_, name_, problem);
  if (problem) {
    throw Error("-o " + name_.string() + ": something has come there meanwhile (" +
                problem.message() + "); " + remedy);
  }
}

}  // namespace palpate
