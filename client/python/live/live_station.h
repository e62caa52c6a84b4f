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

/// Nobody answers any more: what was asked for may yet come.
class Silence : public Error {
 public:
  using Error::Error;
};

/// Held while a participant is made, which not several threads may do at once.
std::mutex& MakingParticipants();

struct LiveStationOptions {
  LinkOptions link;           ///< its `realtime` counts for nothing: a program is not real-time
  std::optional<Pose> start;  ///< none: where the server says that a hand begins
  double max_force_N = 100.0;
  double max_torque_Nm = 10.0;
  bool local_model = true;
};

/// A station like any other, with the same loop, link and limiter, whose hand a program moves.
/// Thread contract: any threads, but one at a time moves the hand.
class LiveStation {
 public:
  /// Waits until it has a session, or is held.
  /// @param wait  called where time passes; may throw, which ends all.
  /// Throws Error as palpate-station does: nobody answers, no such scene, the server refuses.
  LiveStation(LiveStationOptions options, const WaitOrStop& wait);
  /// Leaves the session.
  ~LiveStation() { Close(); }
  LiveStation(const LiveStation&) = delete;
  LiveStation& operator=(const LiveStation&) = delete;

  /// Moves the hand (PosedDevice::Go) and waits until the server has answered a pose that was
  /// sampled at the end of the move.
  /// @param X_WH        finite, its quaternion of length 1.
  /// @param patience_s  how long that answer may take once the hand is there [s], and any while it
  ///                    is on its way.
  /// Throws Silence where no answer comes, and Error where the session is over for good.
  Felt Move(const Pose& X_WH, double seconds, double patience_s, const WaitOrStop& wait);
  /// Leads the hand (PosedDevice::Lead).
  void Lead(const HeldWrench& held) { device_->Lead(held); }
  /// Of the newest tick; without a true reply its forces are zero.
  Felt felt() { return device_->felt(); }
  /// SessionLink::PhaseText; "closed", or "over" where `Move` would throw.
  std::string phase() const;
  /// What was told of the session since the last call, a line each, for people.
  std::vector<std::string> TakeNews();
  const std::string& scene() const { return scene_; }
  std::string tool() const;
  const std::string& name() const { return name_; }
  /// Poses sent, and answers to them that were used.
  struct Counts {
    std::uint64_t sent = 0, replies = 0, lost = 0;
  };
  Counts counts() const;
  void Close();

 private:
  void Run(const LiveStationOptions& options);
  void Tell(const std::string& news);

  std::string name_, scene_;
  std::optional<dds::Participant> service_;  // kept open, so that the domain is not made anew
  std::unique_ptr<PosedDevice> device_;

  mutable std::mutex mutex_;  // guards what follows
  std::string phase_ = "asking";
  std::string tool_;
  std::string error_;  // the session is over for good
  std::deque<std::string> news_;
  Counts counts_;
  const ServoThread* servo_ = nullptr;  // while there is one

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate
