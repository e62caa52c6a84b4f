#include "client/replayer/export.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/replayer/methods.h"
#include "client/replayer/session_columns.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/output.h"
#include "common/quoted.h"
#include "common/recording/recording_reader.h"
#include "common/time/steady_clock.h"
#include "common/whole_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Waiting rows of all tables together, before they are written.
constexpr std::size_t kMostPending = std::size_t{64} << 20;
/// Samples between looks at the clock and at Ctrl-C.
constexpr std::uint64_t kLook = 4096;

/// Of the file that names those of an export: some hundred thousand names.
constexpr std::uint64_t kMostMethodsBytes = std::uint64_t{16} << 20;

constexpr const char* kMethodsFile = "methods.json";
constexpr const char* kMethodsText = "METHODS.md";

using SessionKey = std::pair<std::string, std::uint64_t>;  // station, run

/// Of a loop topic's name, palpate/STATION/RUN/...; none where it is not one.
std::optional<SessionKey> SessionOfTopic(const std::string& topic) {
  constexpr std::string_view kBegin = "palpate/";
  if (!topic.starts_with(kBegin)) return std::nullopt;
  const std::size_t run_at = topic.find('/', kBegin.size());
  if (run_at == std::string::npos) return std::nullopt;
  std::uint64_t run = 0;
  const char* const digits = topic.data() + run_at + 1;
  const auto [end, problem] = std::from_chars(digits, topic.data() + topic.size(), run, 16);
  const std::string station = topic.substr(kBegin.size(), run_at - kBegin.size());
  if (problem != std::errc() || !dds::IsStationName(station)) return std::nullopt;
  return SessionKey{station, run};
}

std::vector<std::string> FilesBelow(const fs::path& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_directory() && !entry.is_symlink()) continue;
    files.push_back(entry.path().lexically_relative(folder).string());
  }
  return files;
}

/// What a former export says that it made; none where it is no export.
std::optional<std::set<std::string>> FilesOfExport(const fs::path& folder) {
  const auto text = TryReadWholeFile(folder / kMethodsFile, kMostMethodsBytes);
  if (!text) return std::nullopt;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("made_by", "") != kExportMark) return std::nullopt;
  std::set<std::string> files{kMethodsFile, kMethodsText};
  const auto listed = json.find("files");
  if (listed == json.end() || !listed->is_array()) return std::nullopt;
  for (const auto& file : *listed) {
    if (file.is_string()) files.insert(file.get<std::string>());
  }
  return files;
}

/// Throws Error where the folder may not give way to a new export.
void CheckMayMake(const ExportOptions& options) {
  const fs::path folder = options.folder;
  if (!fs::exists(fs::symlink_status(folder))) return;
  if (!fs::is_directory(fs::symlink_status(folder))) {
    throw Error("-o " + options.folder + ": is there already and is no folder; give another name");
  }
  if (fs::is_empty(folder)) return;
  if (!options.overwrite) {
    throw Error("-o " + options.folder +
                ": is there already; give another name, or --overwrite for a former export");
  }
  const auto made = FilesOfExport(folder);
  if (!made) {
    throw Error("-o " + options.folder + ": has no " + kMethodsFile +
                " of an export, and so is not overwritten; give another name");
  }
  for (const std::string& file : FilesBelow(folder)) {
    if (made->contains(file)) continue;
    throw Error("-o " + options.folder + ": holds " + Quoted(file) +
                ", which no export made; move it away, or give another name");
  }
}

/// The folder while it grows: gone with this object, unless it has got its name.
class GrowingFolder {
 public:
  explicit GrowingFolder(const std::string& folder) : name_(folder) {
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
  }
  ~GrowingFolder() {
    std::error_code ignored;
    if (!part_.empty()) fs::remove_all(part_, ignored);
  }
  GrowingFolder(const GrowingFolder&) = delete;
  GrowingFolder& operator=(const GrowingFolder&) = delete;

  const fs::path& path() const { return part_; }
  /// What has the name goes; CheckMayMake has looked at it.
  void Finish() {
    fs::remove_all(name_);
    fs::rename(part_, name_);
    part_.clear();
  }

 private:
  fs::path name_, part_;
};

class Progress {
 public:
  explicit Progress(const std::vector<std::string>& files) : terminal_(isatty(STDERR_FILENO) == 1) {
    for (const std::string& file : files) {
      before_.push_back(total_);
      total_ += fs::file_size(file);
    }
  }
  ~Progress() {
    if (drawn_) std::fputc('\n', stderr);
  }

  void Show(const RecordingReader::Place& place) {
    const std::int64_t now_ns = SteadyNanoseconds();
    if (now_ns - shown_ns_ < (terminal_ ? 500'000'000 : 10'000'000'000)) return;
    shown_ns_ = now_ns;
    const double share = static_cast<double>(before_[place.file] + place.offset) /
                         static_cast<double>(std::max<std::uintmax_t>(total_, 1));
    std::fprintf(stderr, terminal_ ? "\rexporting: %3.0f %%\x1b[K" : "exporting: %3.0f %%\n",
                 100.0 * share);
    std::fflush(stderr);
    drawn_ = terminal_;
  }

 private:
  const bool terminal_;
  bool drawn_ = false;
  std::vector<std::uintmax_t> before_;
  std::uintmax_t total_ = 0;
  std::int64_t shown_ns_ = SteadyNanoseconds();
};

/// Gives each sample to its session.
class Sorter {
 public:
  Sorter(fs::path folder, ColumnFormat format, Methods& methods)
      : folder_(std::move(folder)), format_(format), methods_(methods) {}

  void Add(const RecordedSample& sample, double time_s) {
    wire::HapticPose pose;
    wire::Wrench wrench;
    wire::ToolState tool{};
    wire::SessionState state{};
    wire::LoopStatistics loop{};
    wire::StationStatistics station{};
    wire::GuideTarget guide{};
    if (sample.To(pose)) {
      Give(SessionOfTopic(*sample.topic), pose, time_s);
    } else if (sample.To(wrench)) {
      Give(SessionOfTopic(*sample.topic), wrench, time_s);
    } else if (sample.To(state)) {
      if (state.phase == palpate_SESSION_REFUSED) return;
      if (state.phase != palpate_SESSION_ENDED) run_of_[state.station] = state.run;
      Give(SessionKey{state.station, state.run}, state, time_s);
    } else if (sample.To(tool)) {
      Give(Present(tool.station), tool, time_s);
    } else if (sample.To(loop)) {
      Give(Present(loop.station), loop, time_s);
    } else if (sample.To(station)) {
      Give(SessionKey{station.station, station.run}, station, time_s);
    } else if (sample.To(guide)) {
      Give(Present(guide.station), guide, time_s);
    }
  }
  std::size_t sessions() const { return sessions_.size(); }
  /// The files that it wrote, within the folder.
  std::vector<std::string> Finish() {
    std::vector<std::string> files;
    for (auto& [key, session] : sessions_) {
      session->Close();
      methods_.SessionOf(key.first, key.second).folder = FolderOf(key);
      std::ranges::transform(session->files(), std::back_inserter(files), [&](const auto& file) {
        return fs::path(file).lexically_relative(folder_).string();
      });
    }
    return files;
  }

 private:
  static std::string FolderOf(const SessionKey& key) {
    return fmt::format("{}_{:016x}", key.first, key.second);
  }
  /// The session that a station has now; run 0 where the recording has not told of one.
  SessionKey Present(const std::string& station) const {
    const auto it = run_of_.find(station);
    return {station, it == run_of_.end() ? 0 : it->second};
  }
  template <class T>
  void Give(const std::optional<SessionKey>& key, const T& sample, double time_s) {
    // A file's name is made of it.
    if (!key || !dds::IsStationName(key->first)) return methods_.CountLeftOut();
    std::unique_ptr<SessionColumns>& session = sessions_[*key];
    if (!session) {
      const fs::path folder = folder_ / FolderOf(*key);
      fs::create_directory(folder);
      session = std::make_unique<SessionColumns>(folder.string(), format_);
    }
    session->Add(sample, time_s);
    // Rows are a few hundred bytes: to look at every one's table each time would be the work.
    if (++given_ % kLook != 0) return;
    std::size_t pending = 0;
    for (const auto& [each, columns] : sessions_) pending += columns->pending();
    if (pending < kMostPending) return;
    for (const auto& [each, columns] : sessions_) columns->Flush();
  }

  fs::path folder_;
  ColumnFormat format_;
  Methods& methods_;
  std::map<SessionKey, std::unique_ptr<SessionColumns>> sessions_;
  std::map<std::string, std::uint64_t> run_of_;
  std::uint64_t given_ = 0;
};

}  // namespace

void Export(const ExportOptions& options, StopSignal& stop) {
  RecordingReader reader(options.files);
  CheckMayMake(options);
  GrowingFolder folder(options.folder);
  Methods methods;
  Sorter sorter(folder.path(), options.format, methods);
  {
    Progress progress(options.files);
    RecordedSample sample{};
    std::int64_t began_ns = 0;
    for (std::uint64_t number = 0; reader.Next(sample); ++number) {
      if (number == 0) began_ns = sample.log_time_ns;
      methods.Add(sample);
      sorter.Add(sample, 1e-9 * static_cast<double>(sample.log_time_ns - began_ns));
      if (number % kLook != 0) continue;
      progress.Show(reader.place());
      if (stop.stopped()) {
        throw Error(options.folder + ": stopped before it was whole; nothing is left of it");
      }
    }
  }
  const std::vector<std::string> files = sorter.Finish();
  methods.Finish(reader);
  for (const std::string& problem : reader.problems()) spdlog::warn("{}", Printable(problem));
  if (files.empty()) {
    throw Error(options.files.front() +
                ": holds no sample of a session; 'palpate-record info' says what it holds");
  }
  WriteOutput("-o", (folder.path() / kMethodsFile).string(), methods.ToJson(options.files, files));
  WriteOutput("-o", (folder.path() / kMethodsText).string(), methods.ToMarkdown(options.files));
  folder.Finish();
  std::printf("%s: %zu tables of %zu sessions, methods.json and METHODS.md\n",
              options.folder.c_str(), files.size(), sorter.sessions());
}

}  // namespace palpate
