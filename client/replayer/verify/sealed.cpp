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
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/score/score_plot.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/files/whole_file.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

const std::vector<const char*> kVerified = {
    "Each seal bears the signature of the key that is named above, and says whose trial it is.",
    "Each recording is the one that was sealed: its SHA-256 is the seal's.",
    "Each force that the server answered was computed again by this version, from the recorded "
    "motion and scene, and is the same in every bit.",
    "No recording and no session was handed in twice."};
const std::vector<const char*> kNotVerified = {
    "Who held the stylus or the mouse: a seal says with whose link the page was opened.",
    "Where the motion came from: the server believes what a station says of its hand.",
    "That only the server has the key: it lies in the course's folder, and who reads that folder "
    "can "
    "seal what he likes.  The teacher, and whoever runs the server, are trusted.",
    "The times: they are those of the server's clock.",
    "Points: they are computed from the recordings, by palpate-replay score."};

std::string TimeText(std::int64_t s) {
  return fmt::format("{:%F %T} UTC", fmt::gmtime(static_cast<std::time_t>(s)));
}

std::string EndsIn(const std::string& text, const char* ending) {
  return text.substr(0, text.size() - std::string_view(ending).size());
}

/// The files below a folder with this ending, by their paths from there.
std::vector<std::string> FilesBelow(const std::string& folder, const char* ending) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(ending)) continue;
    files.push_back(entry.path().lexically_relative(folder).string());  // a link is no other place
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
    verdict.seal = OpenSeal(ReadWholeFile(path, kLargestSeal), key, file);
  } catch (const Error& error) {
    verdict.refused = error.what();
  }
  return verdict;
}

std::string NumberedName(const std::string& exam, std::int64_t number) {
  return fmt::format("{}-{}", exam, number);
}

/// Leaves one exam's.  What no key of ours has sealed may be of any, and stays.
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
    throw Error("--exam " + wanted + ": no trial of it is sealed by this key");
  }
  const std::string exam = exams.empty() ? "" : *exams.begin();
  std::erase_if(trials, [&](const SealedVerdict& trial) {
    return trial.seal && NumberedName(trial.seal->exam, trial.seal->exam_number) != exam;
  });
  return exam;
}

/// What its bytes are, and what the physics says of them.  Returns why it is refused.
std::string Judge(const std::string& recording, const VerifyOptions& options,
                  SealedVerdict& verdict) {
  const Seal& seal = *verdict.seal;
  std::error_code none;
  if (!fs::exists(recording, none)) return "its recording is not there";
  const HashedFile hashed = Sha256OfFile(recording);
  if (hashed.bytes < seal.bytes) {
    return fmt::format("its recording is cut: {} of {} bytes are there", hashed.bytes, seal.bytes);
  }
  if (hashed.sha256 != seal.sha256) return "its recording has been changed since it was sealed";
  const Verification verification = Verify({recording}, options);
  for (const SessionVerdict& session : verification.sessions) {
    if (session.station != seal.station) {
      return fmt::format("its recording is of station '{}', and not of '{}'",
                         Printable(session.station), seal.station);
    }
    if (session.scene != seal.scene || session.scene_hash != seal.scene_hash) {
      return fmt::format("its recording is in scene '{}' of hash {}, and not in '{}' of {}",
                         Printable(session.scene), Printable(session.scene_hash), seal.scene,
                         seal.scene_hash);
    }
    verdict.wrenches += session.verified;
    verdict.recorded_s += session.recorded_s;
    verdict.sessions.emplace_back(session.station, session.run);
  }
  // Where nobody has moved a tool there is nothing to compute.
  const bool good = std::ranges::all_of(verification.sessions, [](const SessionVerdict& session) {
    return session.good() || session.recorded == 0;
  });
  if (good && !verification.damaged) return "";
  return "what was recorded is not what the physics gives: " + ToText(verification);
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
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) others.emplace_back(work);
  work();
}

/// One recording is one person's, and one trial's.  A copy that is refused anyway spoils nothing.
void RefuseTwice(std::vector<SealedVerdict>& trials) {
  std::map<std::string, std::vector<SealedVerdict*>> by_content;
  for (SealedVerdict& trial : trials) {
    if (!trial.refused.empty() || trial.seal->recording.empty()) continue;
    std::set<std::string> keys = {trial.seal->sha256};
    for (const auto& [station, run] : trial.sessions)
      keys.insert(fmt::format("{} {}", station, run));
    for (const std::string& key : keys) by_content[key].push_back(&trial);
  }
  for (const auto& [key, same] : by_content) {
    if (same.size() < 2) continue;
    for (SealedVerdict* const trial : same) {
      const SealedVerdict* const other = same.front() == trial ? same.back() : same.front();
      trial->refused = fmt::format("the same recording is handed in for {}, task {} ({})",
                                   other->seal->name, other->seal->task, other->file);
    }
  }
}

/// Nothing is left out, and nothing is there that was not handed in.
void CompareToRoll(const std::string& folder, const SealKey& key, Certificate& certificate) {
  const std::string file = folder + "/exams/" + certificate.exam + kRollEnding;
  std::error_code none;
  if (!fs::exists(file, none)) return;
  try {
    certificate.roll = OpenRoll(ReadWholeFile(file, kLargestSeal), key, file);
  } catch (const Error& error) {
    certificate.missing.emplace_back(error.what());
    return;
  }
  std::set<std::string> listed;
  for (const Roll::Entry& entry : certificate.roll->trials) {
    if (entry.recording.empty()) continue;
    listed.insert(entry.sha256);
    const auto here = std::ranges::find_if(certificate.trials, [&](const SealedVerdict& trial) {
      return trial.seal && trial.seal->sha256 == entry.sha256 && trial.seal->person == entry.person;
    });
    if (here == certificate.trials.end()) {
      certificate.missing.push_back(fmt::format("{}, task {}: {} was handed in, and is not here",
                                                entry.name, entry.task, entry.recording));
    } else {
      here->counts = entry.counts;
    }
  }
  for (SealedVerdict& trial : certificate.trials) {
    if (!trial.seal || trial.seal->recording.empty() || listed.contains(trial.seal->sha256))
      continue;
    if (trial.refused.empty()) trial.refused = "is not on the exam's roll";
  }
}

std::string WordsOf(const SealedVerdict& trial) {
  std::string text = trial.refused.empty() ? "" : trial.refused;
  if (!trial.seal || !text.empty()) return text;
  if (trial.seal->recording.empty()) {
    text = "nothing was recorded";
  } else if (trial.wrenches == 0) {
    text = "nothing was done in it";
  } else {
    text = fmt::format("{:.1f} s, {} forces, every bit", trial.recorded_s, trial.wrenches);
  }
  if (!trial.seal->whole) text += "; cut short (" + trial.seal->reason + ")";
  if (!trial.counts) text += "; does not count: it was done again";
  return text;
}

std::string Sentence(const Certificate& certificate) {
  const auto refused = std::ranges::count_if(
      certificate.trials, [](const SealedVerdict& trial) { return !trial.refused.empty(); });
  return fmt::format(
      "{}: {} of {} trials verified{}", certificate.good() ? "VERIFIED" : "NOT VERIFIED",
      static_cast<std::ptrdiff_t>(certificate.trials.size()) - refused, certificate.trials.size(),
      certificate.missing.empty() ? "" : fmt::format(", {} missing", certificate.missing.size()));
}

std::vector<std::string> Facts(const Certificate& certificate) {
  std::vector<std::string> facts = {
      "exam: " + (certificate.exam.empty() ? "none" : certificate.exam), "key: " + certificate.key,
      "by: palpate " PALPATE_VERSION ", " + TimeText(certificate.verified_s)};
  const std::optional<Roll>& roll = certificate.roll;
  facts.push_back(roll ? fmt::format("roll: {} trials, open from {} to {}", roll->trials.size(),
                                     TimeText(roll->opened_s), TimeText(roll->closed_s))
                       : "roll: there is none, so whether something was left out is not verified");
  return facts;
}

nlohmann::ordered_json JsonOf(const Certificate& certificate) {
  nlohmann::ordered_json json{{"good", certificate.good()},
                              {"exam", certificate.exam},
                              {"key", certificate.key},
                              {"version", PALPATE_VERSION},
                              {"verified_s", certificate.verified_s},
                              {"took_s", certificate.took_s},
                              {"roll", certificate.roll.has_value()},
                              {"missing", certificate.missing},
                              {"verified", kVerified},
                              {"not_verified", kNotVerified},
                              {"trials", nlohmann::ordered_json::array()}};
  for (const SealedVerdict& trial : certificate.trials) {
    nlohmann::ordered_json one{{"file", trial.file},
                               {"refused", trial.refused},
                               {"wrenches", trial.wrenches},
                               {"recorded_s", trial.recorded_s},
                               {"counts", trial.counts}};
    if (const auto& seal = trial.seal) {
      one["person"] = seal->person;
      one["name"] = seal->name;
      one["task"] = seal->task;
      one["exercise"] = seal->exercise;
      one["n"] = seal->n;
      one["recording"] = seal->recording;
      one["sha256"] = seal->sha256;
      one["exercise_sha256"] = seal->exercise_sha256;
      one["criteria_sha256"] = seal->criteria_sha256;
      one["begun_s"] = seal->begun_s;
      one["ended_s"] = seal->ended_s;
      one["whole"] = seal->whole;
      one["reason"] = seal->reason;
    }
    json["trials"].push_back(one);
  }
  return json;
}

std::string Html(const Certificate& certificate) {
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Certificate: {0}</title>"
      "<style>{1}body {{ font: 14px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 2rem "
      "auto; "
      "padding: 0 1rem; background: var(--paper); color: var(--ink) }} table {{ border-collapse: "
      "collapse; width: 100% }} th, td {{ text-align: left; padding: .3rem .6rem; border-bottom: "
      "1px "
      "solid var(--line); vertical-align: top }} td:last-child {{ overflow-wrap: anywhere }} "
      ".refused "
      "{{ color: var(--alarm) }} @media print {{ body {{ background: #fff; color: #000 }} "
      "}}</style>"
      "<h1>Certificate</h1><p><b>{2}</b></p><ul>",
      Escaped(certificate.exam), kScorePagePalette, Escaped(Sentence(certificate)));
  const auto add_list = [&](const auto& lines) {
    for (const auto& line : lines) page += "<li>" + Escaped(line);
    page += "</ul>\n";
  };
  add_list(Facts(certificate));
  page += "<table><tr><th>Person<th>Task<th>Handed in<th>SHA-256<th>Verdict\n";
  for (const SealedVerdict& trial : certificate.trials) {
    const Seal seal = trial.seal.value_or(Seal{});
    page += fmt::format(
        "<tr><td>{}<td>{}<td>{}<td><code>{}</code><td{}>{}\n",
        Escaped(trial.seal ? fmt::format("{} ({})", seal.name, seal.person) : trial.file),
        trial.seal ? fmt::format("{}: {}", seal.task, Escaped(seal.exercise)) : "",
        trial.seal ? TimeText(seal.ended_s) : "", seal.sha256.substr(0, 16),
        trial.refused.empty() ? "" : " class=\"refused\"",
        Escaped((trial.refused.empty() ? "verified: " : "refused: ") + WordsOf(trial)));
  }
  page += "</table>";
  if (!certificate.missing.empty()) {
    page += "<h2>Missing</h2><ul class=\"refused\">";
    add_list(certificate.missing);
  }
  page += "<h2>What was verified</h2><ul>";
  add_list(kVerified);
  page += "<h2>What was not</h2><ul>";
  add_list(kNotVerified);
  return page + "</html>\n";
}

}  // namespace

bool Certificate::good() const {
  return !trials.empty() && missing.empty() &&
         std::ranges::all_of(trials,
                             [](const SealedVerdict& trial) { return trial.refused.empty(); });
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
  JudgeAll(certificate.trials, [&](SealedVerdict& trial) -> std::string {
    const std::string here = EndsIn(trial.file, kSealEnding) + ".mcap";
    const bool fits = is_one
                          ? fs::path(here).filename() == fs::path(trial.seal->recording).filename()
                          : here == trial.seal->recording;
    if (!fits)
      return fmt::format("it is the seal of {}, and lies beside {}", trial.seal->recording, here);
    return Judge(is_one ? here : options.folder + "/" + here, options.verify, trial);
  });
  RefuseTwice(certificate.trials);
  if (!is_one) CompareToRoll(options.folder, key, certificate);
  certificate.took_s = 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns);
  return certificate;
}

std::string ToText(const Certificate& certificate) {
  std::string text = Sentence(certificate) + "\n";
  for (const std::string& fact : Facts(certificate)) text += "  " + Printable(fact) + "\n";
  text += "\n";
  for (const SealedVerdict& trial : certificate.trials) {
    text +=
        fmt::format("{:<9} {}: {}\n", trial.refused.empty() ? "verified" : "REFUSED",
                    trial.seal ? fmt::format("{} (person {}), task {} {}, trial {}",
                                             trial.seal->name, trial.seal->person, trial.seal->task,
                                             trial.seal->exercise, trial.seal->n)
                               : Printable(trial.file),
                    Printable(WordsOf(trial)));
  }
  for (const std::string& line : certificate.missing) text += "MISSING   " + Printable(line) + "\n";
  text += "\nWhat was verified\n";
  for (const char* line : kVerified) text += fmt::format("  - {}\n", line);
  text += "What was not\n";
  for (const char* line : kNotVerified) text += fmt::format("  - {}\n", line);
  return text;
}

void WriteJson(const Certificate& certificate, const std::string& file) {
  WriteOutput(
      "--json", file,
      JsonOf(certificate).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
          "\n");
}

void WriteCertificate(const Certificate& certificate, const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(folder + ": " + error.message() + "; give --out another place");
  WriteOutput("--out", folder + "/certificate.txt", ToText(certificate));
  WriteOutput("--out", folder + "/certificate.html", Html(certificate));
  WriteJson(certificate, folder + "/certificate.json");
}

}  // namespace palpate
