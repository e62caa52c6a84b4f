#include "client/replayer/export/export.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/replayer/export/export_folder.h"
#include "client/replayer/export/methods.h"
#include "client/replayer/export/session_columns.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/realtime/steady_clock.h"
#include "common/recording/recording_reader.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Writes the waiting rows when all tables together exceed this.
constexpr std::size_t kMostPending = std::size_t{64} << 20;
/// Samples between two checks of clock and Ctrl-C.
constexpr std::uint64_t kLook = 4096;

using SessionKey = std::pair<std::string, std::uint64_t>;  // station, run

class ExportProgress {
 public:
  explicit ExportProgress(const std::vector<std::string>& files)
      : terminal_(isatty(STDERR_FILENO) == 1) {
    for (const std::string& file : files) {
      before_.push_back(total_);
      total_ += fs::file_size(file);
    }
  }
  ~ExportProgress() {
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

/// Passes each sample to its session.
class Sorter {
 public:
  /// @param folder  for the sessions' folders.
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
      Give(dds::SessionOfTopic(*sample.topic), pose, time_s);
    } else if (sample.To(wrench)) {
      Give(dds::SessionOfTopic(*sample.topic), wrench, time_s);
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
  /// Returns the files written, relative to the folder.
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
  static std::string FolderOf(const SessionKey& key) { return key.first + "_" + Hex16(key.second); }
  /// Returns a station's present session; run 0 if the recording has not mentioned any.
  SessionKey Present(const std::string& station) const {
    const auto it = run_of_.find(station);
    return {station, it == run_of_.end() ? 0 : it->second};
  }
  template <class T>
  void Give(const std::optional<SessionKey>& key, const T& sample, double time_s) {
    // The key becomes part of a file's name.
    if (!key || !dds::IsStationName(key->first)) return methods_.CountLeftOut();
    std::unique_ptr<SessionColumns>& session = sessions_[*key];
    if (!session) {
      const fs::path folder = folder_ / FolderOf(*key);
      fs::create_directory(folder);
      session = std::make_unique<SessionColumns>(folder.string(), format_);
    }
    session->Add(sample, time_s);
    // Rows have a few hundred bytes: checking all tables for each one would dominate the time.
    if (++given_ % kLook != 0) return;
    std::size_t pending = 0;
    for (const auto& [each, columns] : sessions_) pending += columns->pending();
    if (pending < kMostPending) return;
    for (const auto& [each, columns] : sessions_) columns->Flush();
  }

  const fs::path folder_;
  ColumnFormat format_;
  Methods& methods_;
  std::map<SessionKey, std::unique_ptr<SessionColumns>> sessions_;
  std::map<std::string, std::uint64_t> run_of_;
  std::uint64_t given_ = 0;
};

}  // namespace

void Export(const ExportOptions& options, StopSignal& stop) {
  RecordingReader reader(options.files);
  ExportFolder folder(options.folder);
  Methods methods;
  Sorter sorter(folder.path(), options.format, methods);
  {
    ExportProgress progress(options.files);
    RecordedSample sample{};
    std::int64_t began_ns = 0;
    for (std::uint64_t number = 0; reader.Next(sample); ++number) {
      if (number == 0) began_ns = sample.log_time_ns;
      methods.Add(sample);
      sorter.Add(sample, 1e-9 * static_cast<double>(sample.log_time_ns - began_ns));
      if (number % kLook != 0) continue;
      progress.Show(reader.place());
      if (stop.stopped()) {
        throw Error(options.folder +
                    ": stopped before it was complete; the partial result was removed");
      }
    }
  }
  const std::vector<std::string> files = sorter.Finish();
  methods.Finish(reader);
  for (const std::string& problem : reader.problems()) spdlog::warn("{}", Printable(problem));
  if (files.empty()) {
    throw Error(options.files.front() +
                ": has no samples of a session; 'palpate-record info' shows its contents");
  }
  WriteOutput("-o", folder.path() / "METHODS.md", methods.ToMarkdown(options.files));
  WriteOutput("-o", folder.path() / "methods.json", methods.ToJson(options.files, files));
  folder.Finish();
  std::printf("%s: %zu tables of %zu sessions, methods.json and METHODS.md\n",
              Printable(options.folder).c_str(), files.size(), sorter.sessions());
}

}  // namespace palpate
