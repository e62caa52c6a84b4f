#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/exam.h"
#include "client/course/sha256.h"

struct evp_pkey_st;

namespace palpate {

/// An Ed25519 key (RFC 8032) of a course's server, which signs the trials of an exam; or only its
/// public part, which verifies the signatures.
class SealKey {
 public:
  static constexpr const char* kFile = "exam-key.pem";
  static constexpr const char* kPublicFile = "exam-key.pub.pem";

  /// Returns the key in a course's folder.  At first use it is created, readable by its owner only,
  /// with its public part beside it.  Throws Error: file and remedy.
  static SealKey OfCourse(const std::string& folder);
  /// Reads a public key.  Throws Error.
  static SealKey ReadPublic(const std::string& file);

  /// SHA-256 of the public key's 32 bytes, by which people compare two keys.
  const std::string& name() const { return name_; }
  /// Returns the signature, 128 hexadecimal digits.  Needs the private part.
  std::string Sign(std::string_view text) const;
  bool Signed(std::string_view text, const std::string& signature) const;

 private:
  explicit SealKey(std::shared_ptr<evp_pkey_st> key);
  std::shared_ptr<evp_pkey_st> key_;
  std::string name_;
};

/// What the server attests about a trial of an exam.  EXAMS.md says what that proves.
struct Seal {
  static constexpr const char* kFormat = "palpate-seal-2";

  std::string format = kFormat;
  std::string software;   ///< "palpate 1.2.3": the version whose physics was felt
  std::string recording;  ///< path relative to the course's folder; empty: nothing was recorded
  std::string sha256;     ///< of the recording
  std::int64_t bytes = 0;
  std::int64_t person = 0;  ///< number in the roster
  std::string name;         ///< the person's name at the time of sealing
  std::string station, scene, scene_hash;
  std::string exam;
  std::int64_t exam_number = 0;
  std::string exam_sha256;  ///< of the exam's file when it was opened
  int task = 0;             ///< from 1
  std::string exercise;
  int n = 0;  ///< trial number of the person in that exercise
  std::string exercise_sha256, criteria_sha256, expert_sha256;
  std::int64_t begun_s = 0, ended_s = 0, sealed_s = 0;  ///< since 1970, server's clock
  bool whole = true;
  std::string reason;    ///< why it ended
  std::string previous;  ///< SHA-256 of the seal before this one in the exam; empty: the first
};

/// The list of all trials of an exam, so that a missing one is noticed.  It exists from the exam's
/// opening on, and is sealed anew with each trial that begins or is sealed: after a kill it tells
/// what may still be sealed.
struct Roll {
  static constexpr const char* kFormat = "palpate-roll-3";
  struct Entry {
    std::int64_t person = 0;
    std::string name;
    int task = 0;  ///< from 1
    std::string exercise;
    int n = 0;
    std::string station, scene, scene_hash;
    std::int64_t begun_s = 0;
    std::int64_t waited_s = 0;      ///< for a seat, since the last trial: the person has it more
    std::string recording, sha256;  ///< as in Seal; empty while it runs
    std::string seal;               ///< SHA-256 of its seal's text; empty: it is not sealed
    std::string lost;               ///< why it never will be; empty: it is or will be
    bool counts = true;             ///< false: the examiner had the trial repeated

    bool is_settled() const { return !seal.empty() || !lost.empty(); }
  };

  std::string format = kFormat;
  std::string software, exam;
  std::int64_t exam_number = 0;
  std::string exam_sha256;
  std::vector<ExamTask> tasks;
  std::int64_t opened_s = 0, ends_s = 0;
  std::int64_t closed_s = 0;  ///< 0: it is open
  bool complete = false;      ///< it is closed, every trial is settled, and this changes no more
  std::string last;           ///< SHA-256 of the last seal's text
  std::vector<Entry> trials;
};

/// What the server attests about a trial that runs: how its recording begins.
struct Mark {
  static constexpr const char* kFormat = "palpate-mark-1";
  std::string format = kFormat;
  std::string software;
  std::int64_t exam_number = 0, person = 0;
  std::string exercise;
  int n = 0;
  std::int64_t bytes = 0;
  std::string sha256;       ///< of the recording's first bytes
  std::int64_t made_s = 0;  ///< since 1970, server's clock
};

/// Tasks as the roll and the course's file store them.  ReadTasks throws nlohmann::json::exception.
std::string TasksText(const std::vector<ExamTask>& tasks);
std::vector<ExamTask> ReadTasks(const std::string& json);

/// Returns the text of a seal's file: one line of JSON without white space, {"key", "sealed",
/// "signature"}, with each object's fields in alphabetical order.  The signature covers the bytes
/// of the value of "sealed", from brace to brace, as they stand in the file.
std::string SealText(const Seal& seal, const SealKey& key);
std::string SealText(const Roll& roll, const SealKey& key);
std::string SealText(const Mark& mark, const SealKey& key);
/// Parses such a file.  Throws Error with the reason if anything in it was changed, or if another
/// key or version sealed it.
/// @param file  named in messages.
Seal OpenSeal(std::string_view text, const SealKey& key, const std::string& file);
Roll OpenRoll(std::string_view text, const SealKey& key, const std::string& file);
Mark OpenMark(std::string_view text, const SealKey& key, const std::string& file);

inline constexpr const char* kSealEnding = ".seal.json";
inline constexpr const char* kRollEnding = ".roll.json";
inline constexpr const char* kMarkEnding = ".mark.json";
inline constexpr std::size_t kLargestSeal = std::size_t{4} << 20;

}  // namespace palpate
