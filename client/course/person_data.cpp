#include "client/course/person_data.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <minizip/zip.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/whole_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReadMe = R"(What this course has of you.

trials.csv            a line for each trial: when, how it ended, points, marks by criterion
EXERCISE/N.mcap       the recording of trial N: the hand's poses and forces, a thousand a second
EXERCISE/N/score.html its score page, which any browser opens

MCAP is an open format (https://mcap.dev).  'palpate-replay N.mcap' plays a recording.
)";

fs::path TrialsOf(const std::string& folder, std::int64_t person) {
  return fs::path(folder) / "trials" / std::to_string(person);
}

/// A ZIP that is being written.
class Zip {
 public:
  explicit Zip(const std::string& path) : zip_(zipOpen64(path.c_str(), APPEND_STATUS_CREATE)) {
    Check(zip_ != nullptr);
  }
  ~Zip() {
    if (zip_ != nullptr) zipClose(zip_, nullptr);
  }
  Zip(const Zip&) = delete;
  Zip& operator=(const Zip&) = delete;

  void Begin(const std::string& name, std::time_t time_s, bool is_large) {
    zip_fileinfo info{};
    std::tm local{};
    if (localtime_r(&time_s, &local) != nullptr) {
      info.tmz_date = {unsigned(local.tm_sec),  unsigned(local.tm_min), unsigned(local.tm_hour),
                       unsigned(local.tm_mday), unsigned(local.tm_mon), unsigned(local.tm_year)};
    }
    constexpr unsigned long kUtf8 = 1 << 11;
    // Stored without compression: recordings are compressed already.
    Check(zipOpenNewFileInZip4_64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, 0, 0,
                                  0, -MAX_WBITS, DEF_MEM_LEVEL, Z_DEFAULT_STRATEGY, nullptr, 0, 0,
                                  kUtf8, is_large ? 1 : 0) == ZIP_OK);
  }
  void Add(const char* bytes, std::size_t count) {
    Check(zipWriteInFileInZip(zip_, bytes, static_cast<unsigned>(count)) == ZIP_OK);
  }
  void End() { Check(zipCloseFileInZip(zip_) == ZIP_OK); }
  void Close() { Check(zipClose(std::exchange(zip_, nullptr), nullptr) == ZIP_OK); }

 private:
  static void Check(bool good) {
    if (!good) throw Error("cannot write the ZIP; check whether the course's disk is full");
  }
  zipFile zip_;
};

void AddText(Zip& zip, const std::string& name, const std::string& text) {
  zip.Begin(name, std::time(nullptr), false);
  zip.Add(text.data(), text.size());
  zip.End();
}

void AddFile(Zip& zip, const std::string& name, const std::string& folder, const fs::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(
      fdopen(OpenFileBelow(folder, path, ~std::uint64_t{0} >> 1), "rb"), std::fclose);
  constexpr std::uintmax_t kLarge = 0xF0000000;
  const auto when = fs::last_write_time(path) - fs::file_time_type::clock::now() +
                    std::chrono::system_clock::now();
  zip.Begin(name,
            std::chrono::system_clock::to_time_t(
                std::chrono::time_point_cast<std::chrono::system_clock::duration>(when)),
            fs::file_size(path) > kLarge);
  std::vector<char> piece(std::size_t{1} << 18);
  while (const std::size_t count = std::fread(piece.data(), 1, piece.size(), in.get())) {
    zip.Add(piece.data(), count);
  }
  if (std::ferror(in.get()) != 0)
    throw Error(path.string() + ": cannot be read completely; check the disk");
  zip.End();
}

void RemoveFiles(RosterTable& table, const std::string& folder, std::int64_t person) {
  std::error_code error;
  fs::remove_all(TrialsOf(folder, person), error);
  if (error) {
    throw Error(
        fmt::format("{}: {}; remaining recordings of a deleted person are removed at the next "
                    "start that has the rights; or remove them by hand",
                    TrialsOf(folder, person).string(), error.message()));
  }
  table.Forget(person);
}

/// Throws Error if a ZIP of that size would take space that recordings need.
void RequireSpace(const std::string& folder, std::uintmax_t bytes, std::uintmax_t left_free) {
  std::error_code unknown;
  const std::uintmax_t there = fs::space(folder, unknown).available;
  if (unknown || (there >= bytes && there - bytes >= left_free)) return;
  throw Error(
      fmt::format("the course's disk has {} MB, and {} MB beside the ZIP of {} MB are kept "
                  "for recordings; free some space, and do it again",
                  there >> 20, left_free >> 20, bytes >> 20));
}

}  // namespace

int GiveData(const std::string& folder, const Person& person, const std::string& csv,
             std::uintmax_t left_free) {
  // Unlinked: simultaneous requests do not collide, and a killed process leaves no file.
  std::string path = folder + "/.given-XXXXXX";
  const int file = mkostemp(path.data(), O_CLOEXEC);
  if (file < 0)
    throw Error(folder + ": " + std::strerror(errno) +
                "; the folder is not writable; check its rights and the space on its disk");
  unlink(path.c_str());
  try {
    Zip zip(fmt::format("/proc/self/fd/{}", file));
    const std::string top = FileNameOf(person.name) + "/";
    AddText(zip, top + "README.txt", kReadMe);
    AddText(zip, top + "trials.csv", csv);
    const fs::path trials = TrialsOf(folder, person.id);
    std::error_code none;
    std::vector<fs::path> files;
    std::uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(trials, none)) {
      // Not what a link leads to: that is nobody's trial.
      if (!fs::is_regular_file(entry.symlink_status())) continue;
      files.push_back(entry.path());
      bytes += entry.file_size();
    }
    RequireSpace(folder, bytes, left_free);
    std::ranges::sort(files);
    for (const fs::path& one : files)
      AddFile(zip, top + one.lexically_relative(trials).string(), folder, one);
    zip.Close();
  } catch (...) {
    close(file);
    throw;
  }
  return file;
}

void DeletePerson(CourseFile& file, const std::string& folder, std::int64_t person) {
  RosterTable table(file);
  table.Delete(person);
  RemoveFiles(table, folder, person);
}

void FinishDeletions(CourseFile& file, const std::string& folder) {
  RosterTable table(file);
  for (const std::int64_t person : table.Deleted()) {
    try {
      RemoveFiles(table, folder, person);
    } catch (const Error& error) {
      spdlog::error("{}", error.what());  // the course goes on
    }
  }
}

}  // namespace palpate
