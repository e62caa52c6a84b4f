#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include <dds/dds.h>

#include "common/dds/participant.h"
#include "common/dds/wire.h"

namespace palpate::dds {

/// Quality of service by role; endpoint.cpp has the table with reasons.
enum class Qos {
  kLoop,     ///< best effort, volatile, keep last (a few): HapticPose, Wrench
  kSession,  ///< reliable, transient-local, keep last 1 per instance: requests, states, changes
  kStream,   ///< best effort, volatile, keep last 1: ToolState, LoopStatistics and the like
  // For readers that need every sample but may be delayed for a while (by a disk, say).
  kRecord,         ///< for kLoop and kStream, keep last 256: the most that shared memory allows
  kRecordSession,  ///< for kSession, keep last 256
};

/// A DDS writer or reader and its topic, which it deletes with itself.  Move-only.  The participant
/// must outlive it.
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
  std::shared_ptr<void> listens_;  // the callback's data; outlives the reader
};

/// Decides in DDS's receiving thread about each sample that arrives: one that is not admitted is
/// dropped before DDS keeps anything of it, neither the sample nor its instance.
class Admission {
 public:
  virtual ~Admission() = default;
  /// Must not call DDS, nor wait for a thread that does.
  virtual bool Admits(std::uint64_t writer, std::uint64_t instance) = 0;
};

/// Writer of T (a type of common/dds/wire.h) on one topic.
template <class T>
class Writer : public Endpoint {
 public:
  /// Throws Error (topic, DDS's reason).
  Writer(const Participant& participant, const std::string& topic, Qos qos);
  Writer() = default;

  /// Writes a sample; false if DDS refuses it (out of chunks, say).  Real-time for loop topics: one
  /// dds_write, no allocation of our own.
  bool Write(const T& sample) noexcept;
  /// Disposes the instance: tells the readers that it is over, and forgets it, so that later
  /// readers do not get it.
  /// @param sample  only its key fields are used.
  /// Not real-time.
  void Dispose(const T& sample) noexcept;
  int matched_readers() const noexcept;
};

/// Reader of T.  With a callback, DDS's own receiving thread delivers each sample on arrival, which
/// halves the round trip of a waitset; without one, poll with Take().
template <class T>
class Reader : public Endpoint {
 public:
  /// Called once per valid sample, oldest first, in the receiving thread: no blocking, no throw.
  using Callback = std::function<void(const T&)>;

  /// Note that the destructor waits until no callback runs, so do not destroy a reader in its own
  /// callback. Throws Error (topic, DDS's reason).
  /// @param admission  outlives the reader; null: everything is admitted.
  Reader(const Participant& participant, const std::string& topic, Qos qos,
         Callback on_sample = nullptr, Admission* admission = nullptr);
  Reader() = default;

  /// Takes the oldest sample not yet taken; false if there is none.
  bool Take(T& sample) noexcept;
  int matched_writers() const noexcept;

 private:
  struct State;  // the callback, at an address that outlives moves
};

/// Returns true once a writer of the topic has been discovered in the participant's domain.  Only
/// then may a reader over shared memory be made: each sample from an undiscovered writer leaks a
/// chunk, and after 257 of them the reader receives nothing ever again.  Not real-time.
bool WriterDiscovered(const Participant& participant, const std::string& topic);

}  // namespace palpate::dds
