#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/python/live/posed_device.h"
#include "client/station/served_tools.h"
#include "client/station/session_link.h"
#include "common/error.h"

namespace palpate {

/// Thrown when no answer arrives in time; one may still come later.
class Silence : public Error {
 public:
  using Error::Error;
};

/// Returns the mutex to hold while making a participant, which only one thread may do at a time.
std::mutex& MakingParticipants();

struct LiveStationOptions {
  LinkOptions link;           ///< its `realtime` is ignored: a script is not real-time
  std::optional<Pose> start;  ///< none: where the server says that a hand begins
  double max_force_N = 100.0;
  double max_torque_Nm = 10.0;
  bool local_model = true;
};

/// A station with palpate-station's loop, link and limiter, whose hand a program moves.
/// Thread contract: any threads, but only one at a time may move the hand.
class LiveStation {
 public:
  /// Waits until it has a session, or is held.
  /// @param wait  called while waiting; may throw, which ends the construction.
  /// Throws Error as palpate-station does: nobody answers, no such scene, the server refuses.
  LiveStation(LiveStationOptions options, const WaitOrStop& wait);
  /// Leaves the session.
  ~LiveStation() { Close(); }
  LiveStation(const LiveStation&) = delete;
  LiveStation& operator=(const LiveStation&) = delete;

  /// Moves the hand (PosedDevice::Go) and waits until the server has answered a pose that was
  /// sampled at the end of the move.
  /// @param X_WH        finite, its quaternion of length 1.
  /// @param patience_s  how long that answer may take once the hand has arrived, and any answer
  ///                    while the hand moves [s].
  /// Throws Silence if no answer comes, and Error if the session has ended for good.
  Felt Move(const Pose& X_WH, double seconds, double patience_s, const WaitOrStop& wait);
  /// Leads the hand (PosedDevice::Lead).
  void Lead(const HeldWrench& held) { device_->Lead(held); }
  /// Returns the newest tick's readings; their forces are zero without a valid reply.
  Felt felt() { return device_->felt(); }
  /// SessionLink::PhaseText; "closed", or "over" if `Move` would throw.
  std::string phase() const;
  /// Returns the messages about the session since the last call, one line each, for people.
  std::vector<std::string> TakeNews();
  const std::string& scene() const { return scene_; }
  std::string tool() const;
  const std::string& name() const { return name_; }
  /// Poses sent, and their answers that were used.
  struct Counts {
    std::uint64_t sent = 0, replies = 0, lost = 0;
  };
  Counts counts() const;
  void Close();

 private:
  void Run(const LiveStationOptions& options);
  void Tell(const std::string& news);

  std::string name_, scene_;
  std::optional<dds::Participant> service_;  // kept open, so that the domain is not created anew
  std::unique_ptr<PosedDevice> device_;

  mutable std::mutex mutex_;  // guards the members below
  std::string phase_ = "asking";
  std::string tool_;
  std::string error_;  // set once the session has ended for good
  std::deque<std::string> news_;
  Counts counts_;
  const ServoThread* servo_ = nullptr;  // while there is one

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate
