#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include <dds/dds.h>

#include "common/dds/participant.h"
#include "common/dds/wire.h"

namespace palpate::dds {

/// Quality of service by role; the table with reasons is in endpoint.cpp.
enum class Qos {
  kLoop,     ///< best effort, volatile, keep last (a few): HapticPose, Wrench
  kSession,  ///< reliable, transient-local, keep last 1 per instance: requests, states, changes
  kStream,   ///< best effort, volatile, keep last 1: ToolState, LoopStatistics and the like
  // For readers that want every sample, and may be held up for a while (by a disk, say).
  kRecord,         ///< of kLoop and kStream, keep last 256: the most that shared memory has
  kRecordSession,  ///< of kSession, keep last 256
};

/// A writer or reader of DDS with its topic, which end together.  Move-only.  The participant must
/// outlive it.
class Endpoint {
 public:
  Endpoint() = default;
  Endpoint(Endpoint&& other) noexcept { *this = std::move(other); }
  Endpoint& operator=(Endpoint&& other) noexcept;

  bool uses_shared_memory() const noexcept;
  dds_entity_t handle() const { return endpoint_; }
  explicit operator bool() const { return endpoint_ > 0; }

 protected:
  ~Endpoint();

  dds_entity_t topic_ = 0, endpoint_ = 0;
  std::shared_ptr<void> listens_;  // what a callback uses; outlives the reader
};

/// Writer of T (a type of common/dds/wire.h) on one topic.
template <class T>
class Writer : public Endpoint {
 public:
  /// Throws Error (topic, DDS's reason).
  Writer(const Participant& participant, const std::string& topic, Qos qos);
  Writer() = default;

  /// Real-time where the topic is a loop topic: one dds_write, no allocation of ours.
  /// Returns false where DDS refuses (out of chunks, say); never throws.
  bool Write(const T& sample) noexcept;
  /// Tells readers that this instance is over, and forgets it: who comes later hears nothing of it.
  /// @param sample  its key fields count.   Not real-time.
  void Dispose(const T& sample) noexcept;
  int matched_readers() const noexcept;
};

/// Reader of T.  With a callback, samples are handed over in DDS's own receiving thread as they
/// arrive (half the round trip of a waitset); else Take() polls.
template <class T>
class Reader : public Endpoint {
 public:
  /// Called once per valid sample, oldest first, in the receiving thread: no blocking, no throw.
  using Callback = std::function<void(const T&)>;

  /// Its end returns only when no callback runs any more; hence not to be destroyed in a callback.
  /// Throws Error (topic, DDS's reason).
  Reader(const Participant& participant, const std::string& topic, Qos qos,
         Callback on_sample = nullptr);
  Reader() = default;

  /// Takes the oldest sample not yet taken; false where there is none.
  bool Take(T& sample) noexcept;
  int matched_writers() const noexcept;

 private:
  struct State;  // the callback, at an address that outlives moves
};

/// True once a writer of the topic has been discovered in the participant's domain: only then may a
/// reader over shared memory be made (each sample from an undiscovered writer leaks a chunk, and
/// after 257 the reader is dead for ever).  Not real-time.
bool WriterDiscovered(const Participant& participant, const std::string& topic);

}  // namespace palpate::dds
