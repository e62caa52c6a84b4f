#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/recorder/sample_queue.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/recording/recorded_type.h"

namespace palpate {

/// Everything that is heard of a server: readers on all service topics, and on the two loop topics
/// of each session as sessions come and go.  All samples go into the queue; nothing else is done in
/// the threads that receive them.
/// Thread contract: one thread.
class Taps {
 public:
  /// @param loop      false: service topics alone.
  /// @param stations  whose sessions are recorded; empty: all.
  /// Throws Error.
  Taps(int domain, const dds::Network& network, const dds::TransportChoice& transport, bool loop,
       std::vector<std::string> stations, SampleQueue& queue, TappedTopics& topics);
  ~Taps();
  Taps(const Taps&) = delete;
  Taps& operator=(const Taps&) = delete;

  /// To be called every few milliseconds.
  void Poll(std::int64_t now_ns);
  /// Sessions whose loop topics are being read.
  int sessions() const;
  /// True once a sample came from a server.
  bool heard() const { return heard_; }

 private:
  struct Session {
    std::uint64_t run = 0;
    std::int64_t ended_ns = 0;
    dds::Reader<wire::HapticPose> poses;
    dds::Reader<wire::Wrench> wrenches;
  };

  template <class T>
  void TapService(const char* name, dds::Qos qos);
  template <class T>
  void Drain(dds::CdrReader<T>& reader, std::uint32_t channel);
  template <class T>
  void Tap(dds::Reader<T>& reader, const std::string& topic);
  void OnState(const wire::SessionState& state, std::int64_t now_ns);
  bool IsWanted(const std::string& station) const;

  const std::vector<std::string> wanted_;
  SampleQueue& queue_;
  TappedTopics& topics_;
  dds::Participant service_;
  std::unique_ptr<dds::Participant> loop_;
  std::vector<std::function<void()>>
      drains_;  // of service topics: scenes first, then who uses them
  std::int64_t now_ns_ = 0;
  bool heard_ = false;
  std::map<std::string, Session> sessions_;  // by station
};

/// Nanoseconds since 1970 that never go back: the wall clock as it was at first, and the steady one
/// since.
std::int64_t RecordingTime_ns();

}  // namespace palpate
