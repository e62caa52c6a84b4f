#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/course/seal.h"
#include "client/replayer/verify/verify.h"

namespace palpate {

struct SealedOptions {
  std::string folder = {};     ///< of the course, or of a copy of it
  std::string recording = {};  ///< this one alone, instead of a folder's
  std::string exam = {};       ///< NAME or NAME-NUMBER; empty: the only one
  std::string key = {};        ///< file with the course's public key
  VerifyOptions verify = {};
};

/// The result for one trial that was handed in.
struct SealedVerdict {
  std::string file;          ///< of its seal
  std::optional<Seal> seal;  ///< none: not sealed with that key, or changed since
  std::string sha256;        ///< of the seal's text
  std::string refused;       ///< the reason; empty: it is what its seal says
  std::uint64_t wrenches = 0;
  double recorded_s = 0.0;
  bool counts = true;                       ///< false: the examiner had it repeated
  std::vector<Restoration> restorations{};  ///< of its scene, while it ran
  /// Computed from the recording with the sealed criteria and expert; none: nothing was touched, it
  /// was refused, or these files are not the sealed ones.
  std::optional<double> points{};
  std::vector<std::pair<std::string, std::uint64_t>> sessions{};  ///< stations and their runs
};

/// The verification of an exam: what was verified and what was not.
struct Certificate {
  std::string exam;
  std::string key;  ///< SealKey::name
  std::optional<Roll> roll;
  std::vector<SealedVerdict> trials;
  std::vector<std::string> missing;    ///< entries of the roll without a trial, or the roll itself
  std::vector<std::string> changed{};  ///< files of a grade that are not the sealed ones
  LocalText title{};                   ///< of the exam; empty: its file is not there or was changed
  std::map<std::string, LocalText> titles{};  ///< of its exercises, likewise
  std::int64_t verified_s = 0;                ///< since 1970, by this computer's clock
  double took_s = 0.0;
  /// True if every trial that was handed in is present, and every one that counts is what its seal
  /// says and was recomputed bit for bit, and if all from which it is graded is as it was sealed.
  bool good() const;
};

/// Checks seals, then hashes, then recomputes all wrenches, on all processors.  The certificate
/// lists what is refused.  Throws Error if key or folder cannot be read, or there is no exam.
Certificate VerifySealed(const SealedOptions& options);

}  // namespace palpate
