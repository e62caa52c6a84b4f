#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

struct evp_pkey_st;

namespace palpate {

/// An Ed25519 key (RFC 8032): of a course's server, which seals by it what is handed in in an exam,
/// or its public part, which tells whether a seal is that server's.
class SealKey {
 public:
  static constexpr const char* kFile = "exam-key.pem";
  static constexpr const char* kPublicFile = "exam-key.pub.pem";

  /// The key in a course's folder, which is made at first use for its owner alone, with its public
  /// part beside it.  Throws Error: file and remedy.
  static SealKey OfCourse(const std::string& folder);
  /// A public part.  Throws Error.
  static SealKey ReadPublic(const std::string& file);

  /// SHA-256 of the public part's 32 bytes: by what people compare two keys.
  const std::string& name() const { return name_; }
  /// 128 hexadecimal digits.  Not by a public part.
  std::string Sign(std::string_view text) const;
  bool Signed(std::string_view text, const std::string& signature) const;

 private:
  explicit SealKey(std::shared_ptr<evp_pkey_st> key);
  std::shared_ptr<evp_pkey_st> key_;
  std::string name_;
};

/// Lower-case hexadecimal digits.
std::string Sha256(std::string_view text);
struct HashedFile {
  std::string sha256;
  std::int64_t bytes = 0;
};
/// Throws Error where the file cannot be read.
HashedFile Sha256OfFile(const std::string& file);

/// What the server says of a trial of an exam.  README.md has what that proves.
struct Seal {
  static constexpr const char* kFormat = "palpate-seal-1";

  std::string format = kFormat;
  std::string software;   ///< "palpate 1.2.3": whose physics it was
  std::string recording;  ///< its path below the course's folder; empty: nothing was recorded
  std::string sha256;     ///< of the recording
  std::int64_t bytes = 0;
  std::int64_t person = 0;  ///< of the roster
  std::string name;         ///< the person's, when it was sealed
  std::string station, scene, scene_hash;
  std::string exam;
  std::int64_t exam_number = 0;
  std::string exam_sha256;  ///< of the exam's file as it was opened
  int task = 0;             ///< from 1
  std::string exercise;
  int n = 0;  ///< of the person's trials of that exercise
  std::string exercise_sha256, criteria_sha256;
  std::int64_t begun_s = 0, ended_s = 0, sealed_s = 0;  ///< since 1970, by the server's clock
  bool whole = true;
  std::string reason;  ///< why it ended
};

/// Of an exam that was closed: what was handed in, so that nothing is left out unnoticed.
struct Roll {
  static constexpr const char* kFormat = "palpate-roll-1";
  struct Entry {
    std::int64_t person = 0;
    std::string name;
    int task = 0;
    std::string recording, sha256;  ///< as in Seal
    bool counts = true;             ///< false: the examiner had it done again
  };

  std::string format = kFormat;
  std::string software, exam;
  std::int64_t exam_number = 0;
  std::string exam_sha256;
  std::int64_t opened_s = 0, closed_s = 0;
  int tasks = 0;
  std::vector<Entry> trials;
};

/// The text of a seal's file: one line of JSON without white space, {"key", "sealed", "signature"},
/// the fields of each object in the order of their names.  Signed are the bytes of the value of
/// "sealed", from brace to brace, as they stand in the file.
std::string SealText(const Seal& seal, const SealKey& key);
std::string SealText(const Roll& roll, const SealKey& key);
/// What such a file says.  Throws Error with the reason where anything of it has been changed, or
/// it is sealed by another key or by another version.
/// @param file  for messages.
Seal OpenSeal(std::string_view text, const SealKey& key, const std::string& file);
Roll OpenRoll(std::string_view text, const SealKey& key, const std::string& file);

inline constexpr const char* kSealEnding = ".seal.json";
inline constexpr const char* kRollEnding = ".roll.json";
inline constexpr std::size_t kLargestSeal = std::size_t{4} << 20;

}  // namespace palpate
