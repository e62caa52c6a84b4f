#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/course/seal.h"
#include "client/replayer/verify/verify.h"

namespace palpate {

struct SealedOptions {
  std::string folder;     ///< of the course, or a copy of it
  std::string recording;  ///< this one alone, in place of a folder's
  std::string exam;       ///< NAME or NAME-NUMBER; empty: the only one there is
  std::string key;        ///< file of the course's public key
  VerifyOptions verify;
};

/// What became of one trial that was handed in.
struct SealedVerdict {
  std::string file;          ///< of its seal
  std::optional<Seal> seal;  ///< none: it is not of that key, or has been changed
  std::string refused;       ///< why; empty: it is what its seal says
  std::uint64_t wrenches = 0;
  double recorded_s = 0.0;
  bool counts = true;  ///< false: the examiner had it done again
  std::vector<std::pair<std::string, std::uint64_t>> sessions{};  ///< stations and their runs
};

/// What was verified of an exam, and what was not.
struct Certificate {
  std::string exam;
  std::string key;  ///< SealKey::name
  std::optional<Roll> roll;
  std::vector<SealedVerdict> trials;
  std::vector<std::string> missing;  ///< of what the roll has
  std::int64_t verified_s = 0;       ///< since 1970, by this computer's clock
  double took_s = 0.0;
  /// All that was handed in is there, is what its seal says, and was computed again, bit for bit.
  bool good() const;
};

/// Checks seals, then hashes, then computes all wrenches again, on all processors.  What is not as
/// it should be is refused in the certificate.  Throws Error where key or folder cannot be read, or
/// there is no exam.
Certificate VerifySealed(const SealedOptions& options);

}  // namespace palpate
