#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/dds/endpoint.h"

namespace palpate::dds {

/// A sample as it travelled: the 4-byte encapsulation header and the CDR payload.
struct CdrSample {
  std::vector<std::uint8_t> cdr;
  std::uint64_t instance = 0;       ///< equal for samples of equal keys, in one process
  std::int64_t source_time_ns = 0;  ///< when it was written, by the writer's wall clock
  std::uint64_t origin = 0;         ///< whose it is: a participant; 0: one that has gone
  bool over = false;  ///< the instance is disposed; the sample is its key, and no bytes
};

/// Reader of T that keeps the bytes, for those who pass samples on as they are.  Polls.  Not for
/// the loop's topics: what comes through shared memory was never serialised.
template <class T>
class CdrReader {
 public:
  /// Throws Error (topic, DDS's reason).
  CdrReader(const Participant& participant, const std::string& topic, Qos qos)
      : reader_(participant, topic, qos) {}

  /// Takes the oldest sample not yet taken, as bytes and as a struct; false where there is none.
  /// @param overs   takes the word that an instance is over, too.
  /// @param sample  what it owned before is freed; what it owns then is the caller's: FreeContents.
  bool Take(CdrSample& raw, T& sample, bool overs = false);
  int matched_writers() const noexcept { return reader_.matched_writers(); }
  /// True while a writer of that participant lives.
  bool Hears(std::uint64_t origin) const;

 private:
  std::uint64_t OriginOf(dds_instance_handle_t writer);

  Reader<T> reader_;
  std::map<dds_instance_handle_t, std::uint64_t> origins_;  // by writer
};

/// Frees the sequences that DDS allocated in a sample, and clears it.
template <class T>
void FreeContents(T& sample) noexcept {
  dds_sample_free(&sample, &wire::Descriptor<T>(), DDS_FREE_CONTENTS);
  sample = T{};
}

/// A sample that frees its sequences with itself, however its scope is left.
template <class T>
struct Owned {
  T value{};
  Owned() = default;
  ~Owned() { FreeContents(value); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
};

}  // namespace palpate::dds
