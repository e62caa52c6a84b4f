#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/dds/endpoint.h"

namespace palpate::dds {

/// A sample as it was transmitted: the 4-byte encapsulation header and the CDR payload.
struct CdrSample {
  std::vector<std::uint8_t> cdr;
  std::uint64_t instance = 0;       ///< equal for samples of equal keys, within one process
  std::int64_t source_time_ns = 0;  ///< time of writing, by the writer's wall clock
  std::uint64_t origin = 0;         ///< the participant that wrote it; 0: it has left
  bool over = false;  ///< the instance is disposed: the sample has its key only, and no bytes
};

/// A polling reader of T that keeps the serialised bytes, for programs that forward samples
/// unchanged. Not for the loop's topics: samples from shared memory were never serialised.
template <class T>
class CdrReader {
 public:
  /// Throws Error (topic, DDS's reason).
  CdrReader(const Participant& participant, const std::string& topic, Qos qos)
      : reader_(participant, topic, qos) {}

  /// Takes the oldest sample not yet taken, as bytes and as a struct; false if there is none.
  /// @param overs   also takes the notice that an instance is disposed.
  /// @param sample  its old contents are freed; the caller frees the new ones with FreeContents.
  bool Take(CdrSample& raw, T& sample, bool overs = false);
  int matched_writers() const noexcept { return reader_.matched_writers(); }
  /// Returns true while a writer of that participant is alive.
  bool Hears(std::uint64_t origin) const;

 private:
  std::uint64_t OriginOf(dds_instance_handle_t writer);

  Reader<T> reader_;
  std::map<dds_instance_handle_t, std::uint64_t> origins_;  // keyed by writer
};

/// Frees the sequences that DDS has allocated in a sample, and clears the sample.
template <class T>
void FreeContents(T& sample) noexcept {
  dds_sample_free(&sample, &wire::Descriptor<T>(), DDS_FREE_CONTENTS);
  sample = T{};
}

/// A sample whose destructor frees its sequences.
template <class T>
struct Owned {
  T value{};
  Owned() = default;
  ~Owned() { FreeContents(value); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
};

}  // namespace palpate::dds
