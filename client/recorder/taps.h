#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "client/recorder/sample_queue.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/recording/recorded_type.h"

namespace palpate {

/// Subscribes to all that a server publishes: all service topics, and the two loop topics of each
/// session as sessions come and go.  The receiving threads only put samples into the queue.
/// One server is recorded at a time: what others say is dropped as it arrives, as long as it lives
/// and, while it has sessions, speaks.
/// Thread contract: one thread.
class Taps {
 public:
  /// @param loop      false: service topics only.
  /// @param stations  stations whose sessions are recorded; empty: all.
  /// Throws Error.
  Taps(int domain, const dds::Network& network, const dds::TransportChoice& transport, bool loop,
       std::vector<std::string> stations, SampleQueue& queue, TappedTopics& topics);
  ~Taps();
  Taps(const Taps&) = delete;
  Taps& operator=(const Taps&) = delete;

  /// Call it every few milliseconds.
  void Poll(std::int64_t now_ns);
  /// Returns the number of sessions whose loop topics are being read.
  int sessions() const;
  /// True once a sample has arrived from a server.
  bool heard() const { return heard_; }
  /// True once a scene of that name has arrived, with its bundle.
  bool has_scene(const std::string& name) const;

 private:
  struct Session {
    std::uint64_t run = 0, origin = 0;
    std::int64_t active_ns = 0;  // since when its tool's state comes; 0: not yet
    std::int64_t ended_ns = 0;
    dds::Reader<wire::HapticPose> poses;
    dds::Reader<wire::Wrench> wrenches;
  };

  template <class T>
  std::shared_ptr<dds::CdrReader<T>> TapService(const char* name, dds::Qos qos);
  void TapServer();
  void TapOthers();
  /// Checks whether the server is still the one to record; if not, another may take its place.
  void Succeed();
  template <class T>
  void Drain(dds::CdrReader<T>& reader, std::uint32_t channel);
  template <class T>
  void Tap(dds::Reader<T>& reader, const std::string& topic);
  void OnState(const wire::SessionState& state, std::uint64_t origin, std::int64_t now_ns);
  bool IsWanted(const std::string& station) const;

  const std::vector<std::string> wanted_;
  SampleQueue& queue_;
  TappedTopics& topics_;
  dds::Participant service_;
  std::unique_ptr<dds::Participant> loop_;
  const std::shared_ptr<dds::Source> server_ = std::make_shared<dds::Source>();
  const std::shared_ptr<dds::Source> anyone_ = std::make_shared<dds::Source>(dds::Source::kFew);
  // Of service topics: scenes first, then the topics that refer to them.
  std::vector<std::function<void()>> drains_, other_drains_;
  std::shared_ptr<dds::CdrReader<wire::SessionState>> states_;
  std::uint64_t origin_ = 0;  // the server's participant; 0: none is known
  std::int64_t spoke_ns_ = 0, looked_ns_ = 0;
  bool is_silent_ = false;  // though it has a session: others are heard as well
  std::int64_t now_ns_ = 0;
  bool heard_ = false;
  std::map<std::string, std::uint64_t> scenes_;  // hashes of their bundles, by name
  std::set<std::uint64_t> bundles_;              // that have arrived: seats share one
  std::map<std::string, Session> sessions_;      // by station
};

/// Returns nanoseconds since 1970 that never decrease: the wall clock at the first call plus the
/// steady clock's progress since.
std::int64_t RecordingTime_ns();

}  // namespace palpate
