#include "client/replayer/verify/sealed.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <thread>
#include <tuple>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "client/replayer/score/score_report.h"
#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/program/machine.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::string EndsIn(const std::string& text, const char* ending) {
  return text.substr(0, text.size() - std::string_view(ending).size());
}

/// Returns the files below a folder with this ending, by their relative paths.
std::vector<std::string> FilesBelow(const std::string& folder, const char* ending) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(ending)) continue;
    // Relative to the folder; does not follow links.
    files.push_back(entry.path().lexically_relative(folder).string());
  }
  if (error) throw Error(folder + ": cannot be read (" + error.message() + "); give a course's");
  std::ranges::sort(files);
  return files;
}

SealedVerdict Opened(const std::string& folder, const std::string& file, const SealKey& key) {
  SealedVerdict verdict;
  verdict.file = file;
  try {
    const std::string path = folder.empty() ? file : folder + "/" + file;
    const std::string text = ReadWholeFile(path, kLargestSeal);
    verdict.seal = OpenSeal(text, key, file);
    verdict.sha256 = Sha256(text);
  } catch (const Error& error) {
    verdict.refused = error.what();
  }
  return verdict;
}

std::string NumberedName(const std::string& exam, std::int64_t number) {
  return fmt::format("{}-{}", exam, number);
}

/// Keeps the trials of one exam.  Those that no key of ours has sealed may be of any exam,
/// and stay.
std::string ChooseExam(const std::string& wanted, std::vector<SealedVerdict>& trials) {
  std::set<std::string> exams;
  for (const SealedVerdict& trial : trials) {
    if (!trial.seal) continue;
    const std::string name = NumberedName(trial.seal->exam, trial.seal->exam_number);
    if (wanted.empty() || wanted == name || wanted == trial.seal->exam) exams.insert(name);
  }
  if (exams.size() > 1) {
    std::string list;
    for (const std::string& exam : exams) list += (list.empty() ? "" : ", ") + exam;
    throw Error("there are several exams: " + list + "; choose with --exam");
  }
  if (exams.empty() && !wanted.empty()) {
    throw Error("--exam " + wanted +
                ": no trial of this exam is sealed by this key; give another --exam or --key");
  }
  const std::string exam = exams.empty() ? "" : *exams.begin();
  std::erase_if(trials, [&](const SealedVerdict& trial) {
    return trial.seal && NumberedName(trial.seal->exam, trial.seal->exam_number) != exam;
  });
  return exam;
}

/// Checks the recording's bytes, then its physics.  Returns why it is refused; empty if it is not.
std::string Judge(const std::string& recording, const VerifyOptions& options,
                  SealedVerdict& verdict) {
  const Seal& seal = *verdict.seal;
  std::error_code none;
  if (!fs::exists(recording, none)) return "its recording is not there";
  const HashedFile hashed = Sha256OfFile(recording);
  if (hashed.bytes < seal.bytes) {
    return fmt::format("its recording is truncated: {} of {} bytes exist", hashed.bytes,
                       seal.bytes);
  }
  if (hashed.sha256 != seal.sha256) return "its recording has been changed since it was sealed";
  const Verification verification = Verify({recording}, options);
  verdict.restorations = verification.restorations;
  for (const SessionVerdict& session : verification.sessions) {
    if (session.station != seal.station) {
      return fmt::format("its recording is of station '{}', not of '{}'",
                         Printable(session.station), seal.station);
    }
    if (session.scene != seal.scene || session.scene_hash != seal.scene_hash) {
      return fmt::format("its recording is of scene '{}' with hash {}, not of '{}' with {}",
                         Printable(session.scene), Printable(session.scene_hash), seal.scene,
                         seal.scene_hash);
    }
    verdict.wrenches += session.verified;
    verdict.recorded_s += session.recorded_s;
    verdict.sessions.emplace_back(session.station, session.run);
  }
  // If no tool was moved, there is nothing to compute.
  const bool good = std::ranges::all_of(verification.sessions, [](const SessionVerdict& session) {
    return session.good() || session.recorded == 0;
  });
  if (good && !verification.damaged) return "";
  return "the recorded wrenches differ from the computed ones: " + ToText(verification);
}

void JudgeAll(std::vector<SealedVerdict>& trials,
              const std::function<std::string(SealedVerdict&)>& judge) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t at = next++; at < trials.size(); at = next++) {
      SealedVerdict& trial = trials[at];
      if (!trial.refused.empty() || trial.seal->recording.empty()) continue;
      try {
        trial.refused = judge(trial);
      } catch (const std::exception& error) {
        trial.refused = error.what();
      }
    }
  };
  std::vector<std::jthread> others;
  for (int i = UsableCores(); i > 1; --i) others.emplace_back(work);
  work();
}

/// Refuses a session that is used for two persons or two trials.  Copies that are refused anyway do
/// not count, nor do equal recordings without a session: all of those that a gateway's death cut
/// short before their first message have the same bytes.
void RefuseTwice(std::vector<SealedVerdict>& trials) {
  std::map<std::pair<std::string, std::uint64_t>, std::vector<SealedVerdict*>> by_session;
  for (SealedVerdict& trial : trials) {
    if (!trial.refused.empty()) continue;
    for (const auto& session : std::set(trial.sessions.begin(), trial.sessions.end())) {
      by_session[session].push_back(&trial);
    }
  }
  for (const auto& [session, same] : by_session) {
    if (same.size() < 2) continue;
    for (SealedVerdict* const trial : same) {
      const SealedVerdict* const other = same.front() == trial ? same.back() : same.front();
      trial->refused = fmt::format("the same recording was also submitted for {}, task {} ({})",
                                   other->seal->name, other->seal->task, other->file);
    }
  }
}

/// Reads the roll.  What it cannot vouch for is missing.
void ReadRoll(const std::string& folder, const SealKey& key, Certificate& certificate) try {
  const std::string file = folder + "/exams/" + certificate.exam + kRollEnding;
  if (std::error_code none; !fs::exists(file, none)) {
    throw Error(file + ": the exam has no roll, so nobody knows what was handed in");
  }
  certificate.roll = OpenRoll(ReadWholeFile(file, kLargestSeal), key, file);
  if (!certificate.roll->complete) {
    throw Error(file + ": the exam was not closed, or its last trials are not sealed; close it");
  }
} catch (const Error& error) {
  certificate.missing.emplace_back(error.what());
}

/// Compares the trials with the roll: nothing may be missing, and nothing may be added.
void CompareToRoll(Certificate& certificate) {
  if (!certificate.roll) return;
  std::set<const SealedVerdict*> listed;
  for (const Roll::Entry& entry : certificate.roll->trials) {
    const auto here = std::ranges::find_if(certificate.trials, [&](const SealedVerdict& trial) {
      return trial.seal && trial.sha256 == entry.seal;
    });
    if (here != certificate.trials.end()) {
      here->counts = entry.counts;
      listed.insert(&*here);
    } else if (entry.lost.empty() || entry.counts) {
      certificate.missing.push_back(
          fmt::format("{}, task {}: trial {} {}", entry.name, entry.task, entry.n,
                      entry.lost.empty() ? "was begun, but its seal is missing here" : entry.lost));
    }
  }
  for (SealedVerdict& trial : certificate.trials) {
    if (trial.seal && trial.refused.empty() && !listed.contains(&trial)) {
      trial.refused = "is not on the exam's roll";
    }
  }
}

/// Follows the seals from the last, which the roll names, to the first: each names the one before.
void FollowChain(Certificate& certificate) {
  if (!certificate.roll || !certificate.missing.empty()) return;
  std::map<std::string, SealedVerdict*> unnamed;
  for (SealedVerdict& trial : certificate.trials) {
    if (trial.seal) unnamed[trial.sha256] = &trial;
  }
  for (std::string next = certificate.roll->last; !next.empty();) {
    const auto named = unnamed.extract(next);
    if (named.empty()) {
      certificate.missing.push_back("a seal that another one names: " + next);
      return;
    }
    next = named.mapped()->seal->previous;
  }
  for (const auto& [sha256, trial] : unnamed) {
    if (trial->refused.empty()) trial->refused = "no other seal names its seal";
  }
}

/// Compares all from which the exam is graded with what was sealed.  Returns the exercises that are
/// the sealed ones, by name.
std::map<std::string, Exercise> CompareInputs(const std::string& folder, Certificate& certificate) {
  std::map<std::string, Exercise> same;
  if (!certificate.roll) return same;
  const Roll& roll = *certificate.roll;
  const std::string file = folder + "/" + roll.exam + kExamEnding;
  try {
    const std::string text = ReadWholeFile(file, JsonNode::kMostBytes);
    if (Sha256(text) != roll.exam_sha256) {
      throw Error(file + ": has been changed since the exam was opened");
    }
    certificate.title = ReadLocalText(JsonNode::Parse(text, file).At("title"));
  } catch (const Error& error) {
    certificate.changed.emplace_back(error.what());
  }
  for (const ExamTask& task : roll.tasks) try {
      const Exercise exercise = LoadExercise(ExerciseFileOf(folder, task.exercise));
      if (!SameFiles(HashedTask(exercise), task)) {
        throw Error(exercise.file +
                    ": it, its criteria or its expert has been changed since the exam was opened");
      }
      certificate.titles[exercise.name] = exercise.title;
      same.emplace(exercise.name, exercise);
    } catch (const Error& error) {
      certificate.changed.emplace_back(error.what());
    }
  return same;
}

/// Returns the points of a verified trial; none if it touches nothing or cannot be scored.
std::optional<double> PointsOf(const std::string& recording, const Exercise& exercise) try {
  const Report report = MakeReport(
      {.expert = exercise.expert, .trials = {recording}, .criteria = exercise.file, .join = true});
  const std::optional<Grade>& grade = report.grades.front();
  return grade ? std::optional(grade->points) : std::nullopt;
} catch (const Error&) {  // such as a recording that ends before its scene was begun
  return std::nullopt;
}

}  // namespace

bool Certificate::good() const {
  return !trials.empty() && missing.empty() && changed.empty() &&
         std::ranges::all_of(trials, [](const SealedVerdict& trial) {
           return trial.refused.empty() || !trial.counts;
         });
}

Certificate VerifySealed(const SealedOptions& options) {
  const std::int64_t began_ns = SteadyNanoseconds();
  const SealKey key = SealKey::ReadPublic(options.key);
  Certificate certificate;
  certificate.key = key.name();
  certificate.verified_s = std::time(nullptr);
  const bool is_one = !options.recording.empty();
  const std::vector<std::string> files =
      is_one ? std::vector{EndsIn(options.recording, ".mcap") + kSealEnding}
             : FilesBelow(options.folder, kSealEnding);
  for (const std::string& file : files) {
    certificate.trials.push_back(Opened(options.folder, file, key));
  }
  if (certificate.trials.empty()) {
    throw Error(options.folder + ": nothing in it is sealed (*" + kSealEnding +
                "); give the folder of a course that has held an exam");
  }
  certificate.exam = ChooseExam(options.exam, certificate.trials);
  std::ranges::stable_sort(certificate.trials, {}, [](const SealedVerdict& trial) {
    const Seal seal = trial.seal.value_or(Seal{});  // what no key has sealed comes first
    return std::tuple(seal.person, seal.task, seal.n);
  });
  std::map<std::string, Exercise> exercises;
  if (!is_one) {
    ReadRoll(options.folder, key, certificate);
    exercises = CompareInputs(options.folder, certificate);
  }
  JudgeAll(certificate.trials, [&](SealedVerdict& trial) -> std::string {
    const std::string here = EndsIn(trial.file, kSealEnding) + ".mcap";
    const bool fits = is_one
                          ? fs::path(here).filename() == fs::path(trial.seal->recording).filename()
                          : here == trial.seal->recording;
    if (!fits)
      return fmt::format("it is the seal of {}, and lies beside {}", trial.seal->recording, here);
    const std::string recording = is_one ? here : options.folder + "/" + here;
    const std::string refused = Judge(recording, options.verify, trial);
    const auto exercise = exercises.find(trial.seal->exercise);
    if (refused.empty() && trial.wrenches > 0 && exercise != exercises.end()) {
      trial.points = PointsOf(recording, exercise->second);
    }
    return refused;
  });
  RefuseTwice(certificate.trials);
  if (!is_one) {
    CompareToRoll(certificate);
    FollowChain(certificate);
  }
  certificate.took_s = 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns);
  return certificate;
}

}  // namespace palpate
