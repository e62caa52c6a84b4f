#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
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

/// Whose samples a program's readers take: anyone's, or those of one participant, its server.
/// Thread contract: any.
class Source {
 public:
  /// For topics that anybody may write and that have few instances, one a station, say.  DDS keeps
  /// some hundred bytes of each as long as its writer lives.
  static constexpr std::size_t kFew = 64, kAll = std::size_t(-1);

  /// @param most  instances of each writer; the others are refused.
  explicit Source(std::size_t most = kAll) : most_instances(most) {}

  const std::size_t most_instances;
  /// @param participant  CdrSample::origin; 0: anyone.
  void Only(std::uint64_t participant) { only_ = participant; }
  bool Allows(std::uint64_t participant) {
    const std::uint64_t only = only_;
    if (only == 0 || participant == only) return true;
    refused_ = true;
    return false;
  }
  /// Returns whether somebody was refused since the last call: a new reader would hear him.
  bool TakeRefused() { return refused_.exchange(false); }

 private:
  std::atomic<std::uint64_t> only_{0};
  std::atomic<bool> refused_{false};
};

/// What a CdrReader knows of its writers.  A writer is admitted until its participant is known,
/// which is when the first of its samples is taken.
class KnownWriters : public Admission {
 public:
  explicit KnownWriters(std::shared_ptr<Source> source) : source_(std::move(source)) {}
  bool Admits(std::uint64_t writer, std::uint64_t instance) override;
  /// Returns the participant of a writer, as `find` said when asked first; 0: it has left.
  template <class Find>
  std::uint64_t OriginOf(std::uint64_t writer, Find find);

 private:
  struct Writer {
    std::uint64_t participant = 0;
    std::set<std::uint64_t> instances;
  };
  Writer& Of(std::uint64_t writer);

  const std::shared_ptr<Source> source_;
  std::mutex mutex_;
  std::map<std::uint64_t, Writer> writers_;
};

/// A polling reader of T that keeps the serialised bytes, for programs that forward samples
/// unchanged. Not for the loop's topics: samples from shared memory were never serialised.
template <class T>
class CdrReader {
 public:
  /// @param source  whose samples it takes; null: anyone's.
  /// Throws Error (topic, DDS's reason).
  CdrReader(const Participant& participant, const std::string& topic, Qos qos,
            std::shared_ptr<Source> source = nullptr)
      : writers_(std::make_unique<KnownWriters>(std::move(source))),
        reader_(participant, topic, qos, nullptr, writers_.get()) {}
  CdrReader(CdrReader&&) = default;
  CdrReader& operator=(CdrReader&&) = delete;  // would free `writers_` under the old reader

  /// Takes the oldest sample not yet taken, as bytes and as a struct; false if there is none.
  /// @param overs   also takes the notice that an instance is disposed.
  /// @param sample  its old contents are freed; the caller frees the new ones with FreeContents.
  bool Take(CdrSample& raw, T& sample, bool overs = false);
  int matched_writers() const noexcept { return reader_.matched_writers(); }
  dds_entity_t handle() const { return reader_.handle(); }
  /// Returns true while a writer of that participant is alive.
  bool Hears(std::uint64_t origin) const;

 private:
  std::unique_ptr<KnownWriters> writers_;  // first: it outlives the reader
  Reader<T> reader_;
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
