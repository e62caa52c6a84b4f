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

/// The two loop topics of a session: poses come in and wrenches go out in DDS's receiving thread,
/// which thereby is the servo thread.  Poses of a mouse are answered in a thread of their own with
/// a lower priority.  The reader is created once the station's writer is discovered.  Wrenches are
/// sent once the station's reader is matched and has had time to match our writer, because over
/// shared memory a sample sent too early leaks a chunk.
///
/// Thread contract: service thread.  The destructor returns once no pose is being answered.
class StationLink {
 public:
  StationLink(const dds::Participant& loop_domain, std::shared_ptr<Session> session);
  StationLink(const StationLink&) = delete;
  StationLink& operator=(const StationLink&) = delete;

  /// Takes the next of these set-up steps if it is time.
  /// @param alone  the servo thread answers no other session
  void Update(std::int64_t now_ns, bool alone);
  Session& session() { return *session_; }
  /// Number of poses dropped because they exceeded the station's share.
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
  dds::Reader<wire::HapticPose> pose_reader_;  // last, so that it is destroyed first
};

}  // namespace palpate
