#include "client/course/exam_seals.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/output.h"
#include "common/files/whole_file.h"
#include "scenes/files/scene_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// A killed gateway loses what was recorded since the last mark, and a recorder writes to the disk
/// every 0.2 s: together less than half a second, on a busy machine, too.
constexpr std::chrono::milliseconds kMark{50};
constexpr std::uint64_t kLargestRecording = ~std::uint64_t{0} >> 1;

/// Closes a descriptor at the end of its scope.
struct Descriptor {
  explicit Descriptor(int fd) : fd(fd) {}
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  const int fd;
};

/// Replaces a file, which is on the disk when this returns.
void WriteKept(const std::string& what, const std::string& file, const std::string& text) {
  WriteOutput(what, file, text, Links::kReplace);
  for (const std::string& path : {file, fs::path(file).parent_path().string()}) {
    const Descriptor opened(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (opened.fd >= 0 && fsync(opened.fd) == 0) continue;
    throw Error(fmt::format("{}: cannot be kept on the disk ({})", path, std::strerror(errno)));
  }
}

/// Cuts a file off after its first bytes.
/// @param fd  of the file, for reading; so no link can lead elsewhere meanwhile.
void CutOff(int fd, const std::string& file, std::int64_t bytes) {
  const Descriptor writable(
      open(fmt::format("/proc/self/fd/{}", fd).c_str(), O_WRONLY | O_CLOEXEC));
  if (writable.fd >= 0 && ftruncate(writable.fd, bytes) == 0) return;
  throw Error(fmt::format("{}: cannot be cut off ({}); this user must be able to write it", file,
                          std::strerror(errno)));
}

/// Returns whether a recorder has not yet closed the file (mcap::Writer locks it meanwhile).
bool Grows(int fd) {
  return flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

template <class T>
bool IsReady(const std::future<T>& future) {
  return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

ExamSeals::ExamSeals(std::string folder)
    : folder_(std::move(folder)),
      key_(SealKey::OfCourse(folder_)),
      marking_([this] { MarkOn(); }) {}

ExamSeals::~ExamSeals() {
  {
    const std::scoped_lock lock(guard_);
    ends_ = true;
  }
  wake_.notify_all();
  marking_.join();
}

std::string ExamSeals::FileOf(const Roll& roll) const {
  return fmt::format("{}/exams/{}-{}{}", folder_, roll.exam, roll.exam_number, kRollEnding);
}

std::string ExamSeals::StemOf(const Key& key) const {
  const auto& [person, exercise, n] = key;
  return fmt::format("{}/trials/{}/{}/{}", folder_, person, exercise, n);
}

const Roll::Entry* ExamSeals::Find(const Key& key) const {
  const auto found = std::ranges::find(roll_.trials, key, KeyOf);
  return found == roll_.trials.end() ? nullptr : &*found;
}

// --- the roll ---

void ExamSeals::Write(const Roll& roll) const {
  const std::string folder = folder_ + "/exams";
  std::error_code error;
  fs::create_directories(folder, error);
  RefuseLinks(folder_, folder);
  WriteKept("roll", FileOf(roll), SealText(roll, key_));
}

void ExamSeals::Open(const Roll& roll) {
  const std::string file = FileOf(roll);
  if (std::error_code none; fs::exists(file, none)) {
    const Roll former = OpenRoll(ReadFileBelow(folder_, file, kLargestSeal), key_, file);
    if (former.closed_s != 0 || !former.trials.empty()) {
      throw Error(file +
                  ": an exam of this number was held before, so course.sqlite is older than it; "
                  "restore the newer one, or move the folder exams away");
    }
  }
  Write(roll);
  roll_ = roll;
  trouble_.clear();
  const std::scoped_lock lock(guard_);
  growing_.clear();
}

void ExamSeals::TakeUp(const Roll& expected) try {
  roll_ = {};
  trouble_.clear();
  const std::string file = FileOf(expected);
  if (!std::ranges::all_of(expected.exam, IsOfName)) throw Error(file + ": is no exam's name");
  Roll roll = OpenRoll(ReadFileBelow(folder_, file, kLargestSeal), key_, file);
  const bool agrees = roll.exam == expected.exam && roll.exam_number == expected.exam_number &&
                      roll.exam_sha256 == expected.exam_sha256 && roll.tasks == expected.tasks &&
                      roll.opened_s == expected.opened_s &&
                      (roll.closed_s != 0 || expected.closed_s == 0);
  if (!agrees) {
    throw Error(file + ": course.sqlite says otherwise of this exam; restore both from one copy");
  }
  roll_ = std::move(roll);
} catch (const Error& error) {
  trouble_ = std::string("nothing of the exam is sealed any more: ") + error.what();
}

void ExamSeals::Change(const std::function<void(Roll&)>& change) {
  if (!trouble_.empty()) throw Error(trouble_);
  Roll changed = roll_;
  change(changed);
  Write(changed);
  roll_ = std::move(changed);
}

void ExamSeals::Begin(const Roll::Entry& entry, std::int64_t now_s) {
  const auto growing = std::make_shared<Growing>();
  growing->file = StemOf(KeyOf(entry)) + ".mcap";
  Mark& mark = growing->mark;
  mark.exam_number = roll_.exam_number;
  mark.person = entry.person;
  mark.exercise = entry.exercise;
  mark.n = entry.n;
  mark.sha256 = Sha256("");
  mark.made_s = now_s;
  WriteMark(mark);
  Change([&](Roll& roll) { roll.trials.push_back(entry); });
  const std::scoped_lock lock(guard_);
  growing_[KeyOf(entry)] = growing;
  wake_.notify_all();
}

// --- marks and seals; from here on in a thread, where const says so ---

void ExamSeals::WriteMark(const Mark& mark) const {
  WriteOutput("mark", StemOf({mark.person, mark.exercise, mark.n}) + kMarkEnding,
              SealText(mark, key_), Links::kReplace);
}

void ExamSeals::ReadOn(Growing& growing, std::int64_t now_s) const {
  std::error_code none;
  if (!growing.hash && !fs::exists(growing.file, none)) return;
  if (!growing.hash) growing.hash = std::make_unique<GrowingHash>(growing.file, folder_);
  growing.hash->ReadOn();
  const HashedFile hashed = growing.hash->so_far();
  if (hashed.bytes == growing.mark.bytes) return;
  growing.mark.bytes = hashed.bytes;
  growing.mark.sha256 = hashed.sha256;
  growing.mark.made_s = now_s;
  WriteMark(growing.mark);
}

void ExamSeals::Poll(std::int64_t now_s) {
  now_s_ = now_s;
  const std::scoped_lock lock(guard_);
  if (trouble_of_marks_) std::rethrow_exception(std::exchange(trouble_of_marks_, nullptr));
}

void ExamSeals::MarkOn() {
  std::unique_lock lock(guard_);
  for (;;) {
    wake_.wait(lock, [this] { return ends_ || !growing_.empty(); });
    if (wake_.wait_for(lock, kMark, [this] { return ends_; })) return;
    const auto all = growing_;
    lock.unlock();
    std::exception_ptr trouble;
    for (const auto& [key, growing] : all) {
      try {
        const std::scoped_lock own(growing->guard);
        ReadOn(*growing, now_s_);
      } catch (...) {
        trouble = std::current_exception();
      }
    }
    lock.lock();
    if (trouble) trouble_of_marks_ = trouble;
  }
}

void ExamSeals::BeginToSeal(const Seal& seal) {
  std::unique_lock lock(guard_);
  const auto found = growing_.find({seal.person, seal.exercise, seal.n});
  const auto growing = found == growing_.end() ? nullptr : found->second;
  lock.unlock();
  Seal next = seal;
  next.previous = roll_.last;
  sealing_ = std::async(std::launch::async, [this, next, growing] {
    return growing ? SealWhole(next, *growing) : SealRest(next);
  });
}

ExamSeals::Done ExamSeals::Sealed(const Seal& seal) const {
  const Key key{seal.person, seal.exercise, seal.n};
  const std::string text = SealText(seal, key_);
  WriteKept("seal", StemOf(key) + kSealEnding, text);
  return {key, text};
}

ExamSeals::Done ExamSeals::SealWhole(Seal seal, Growing& growing) const {
  const std::scoped_lock lock(growing.guard);
  ReadOn(growing, seal.ended_s);
  if (growing.hash) {
    seal.sha256 = growing.mark.sha256;
    seal.bytes = growing.mark.bytes;
  } else {
    seal.recording.clear();
  }
  return Sealed(seal);
}

std::optional<ExamSeals::Done> ExamSeals::FormerSealOf(const Seal& seal) const try {
  const Key key{seal.person, seal.exercise, seal.n};
  const std::string file = StemOf(key) + kSealEnding;
  const std::string text = ReadFileBelow(folder_, file, kLargestSeal);
  const Seal former = OpenSeal(text, key_, file);
  const bool is_it = former.exam_number == seal.exam_number && former.begun_s == seal.begun_s &&
                     former.previous == seal.previous &&
                     Key{former.person, former.exercise, former.n} == key;
  return is_it ? std::optional(Done{key, text}) : std::nullopt;
} catch (const Error&) {  // as usual: there is none
  return std::nullopt;
}

Mark ExamSeals::MarkOf(const Seal& seal) const {
  const Key key{seal.person, seal.exercise, seal.n};
  const std::string file = StemOf(key) + kMarkEnding;
  const Mark mark = OpenMark(ReadFileBelow(folder_, file, kLargestSeal), key_, file);
  if (mark.exam_number != seal.exam_number || Key{mark.person, mark.exercise, mark.n} != key) {
    throw Error(file + ": is another trial's");
  }
  return mark;
}

bool ExamSeals::CutToMark(const std::string& file, const Mark& mark) const {
  const Descriptor recording(OpenFileBelow(folder_, file, kLargestRecording));
  if (Grows(recording.fd)) return false;
  GrowingHash hash(file, folder_);
  hash.ReadOn(mark.bytes);
  if (hash.so_far().sha256 != mark.sha256) {
    throw Error(file + ": was changed while no gateway ran");
  }
  CutOff(recording.fd, file, mark.bytes);
  return true;
}

ExamSeals::Done ExamSeals::SealRest(Seal seal) const {
  // Killed after it was sealed, and before that was entered.
  if (auto former = FormerSealOf(seal)) return *former;
  const Key key{seal.person, seal.exercise, seal.n};
  seal.whole = false;
  seal.reason = kKilled;
  try {
    const Mark mark = MarkOf(seal);
    seal.ended_s = mark.made_s;
    if (mark.bytes == 0) {
      seal.recording.clear();
    } else {
      if (!CutToMark(folder_ + "/" + seal.recording, mark)) return {key};  // it is looked at again
      seal.sha256 = mark.sha256;
      seal.bytes = mark.bytes;
    }
  } catch (const Error& error) {
    return {key, "", fmt::format("it ran when the gateway was killed, and {}", error.what()), true};
  }
  Done done = Sealed(seal);
  done.is_rest = true;
  return done;
}

std::optional<ExamSeals::Done> ExamSeals::Take() {
  if (!sealing_.valid() || !IsReady(sealing_)) return std::nullopt;
  Done done = sealing_.get();
  if (done.text.empty() && done.lost.empty()) return std::nullopt;
  Change([&](Roll& roll) {
    Roll::Entry& entry = *std::ranges::find(roll.trials, done.key, KeyOf);
    entry.lost = done.lost;
    if (!done.lost.empty()) return;
    const Seal seal = OpenSeal(done.text, key_, "it");
    entry.recording = seal.recording;
    entry.sha256 = seal.sha256;
    entry.seal = roll.last = Sha256(done.text);
  });
  {
    const std::scoped_lock lock(guard_);
    growing_.erase(done.key);
  }
  std::error_code none;
  fs::remove(StemOf(done.key) + kMarkEnding, none);
  return done;
}

}  // namespace palpate
