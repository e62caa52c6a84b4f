#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/dds/endpoint.h"
#include "server/session/session.h"
#include "server/transport/background_servo.h"
#include "server/transport/servo_budget.h"

namespace palpate {

/// A session's two loop topics.  Poses in, wrenches out, in DDS's receiving thread, which is
/// thereby the servo thread; a mouse's in a thread of its own, below it.  The reader is made once
/// the station's writer is discovered, and wrenches are sent once the station's reader is matched
/// and has had time to match us: over shared memory a sample that is early leaks a chunk.
///
/// Thread contract: service thread.  The destructor returns when no pose is being answered any
/// more.
class StationLink {
 public:
  StationLink(const dds::Participant& loop_domain, std::shared_ptr<Session> session);
  StationLink(const StationLink&) = delete;
  StationLink& operator=(const StationLink&) = delete;

  /// Takes the next of those steps where it is time.
  /// @param alone  no other session is answered by the servo thread.
  void Update(std::int64_t now_ns, bool alone);
  Session& session() { return *session_; }
  /// Poses that were more than the station's share; not heard.
  std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }

 private:
  void OnPose(const wire::HapticPose& pose) noexcept;
  void Answer(const wire::HapticPose& pose) noexcept;

  const dds::Participant& loop_domain_;
  std::shared_ptr<Session> session_;
  std::string pose_topic_;
  std::int64_t matched_ns_ = 0;
  std::atomic<bool> open_{false};
  std::atomic<bool> alone_{false};
  ServoBudget budget_;
  std::atomic<std::uint64_t> refused_{0};
  wire::Wrench answer_{};
  dds::Writer<wire::Wrench> wrench_writer_;
  std::optional<BackgroundServo> background_;
  dds::Reader<wire::HapticPose> pose_reader_;  // last: the first to go
};

}  // namespace palpate
