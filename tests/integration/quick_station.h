#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "tests/integration/rig.h"
#include "tests/session/session_request.h"

namespace palpate::test {

/// A minimal station, so that many of them take little time.
class QuickStation {
 public:
  explicit QuickStation(std::string name, std::string scene = "cube",
                        dds::Transport transport = dds::Transport::kSharedMemory)
      : name_(std::move(name)),
        scene_(std::move(scene)),
        loop_(dds::Participant::Loop(kDomain, {transport, "as asked"})) {}

  /// Asks for a session, and waits until poses can be sent.  False after 20 s.
  bool Begin(std::uint64_t run) {
    run_ = run;
    answered_ = 0;
    Ask(false);
    if (!Eventually([&] { return Phase() == palpate_SESSION_WAITING; })) return false;
    poses_ = {loop_, dds::PoseTopic(name_, run), dds::Qos::kLoop};
    const std::string topic = dds::WrenchTopic(name_, run);
    if (!Eventually([&] { return dds::WriterDiscovered(loop_, topic); })) return false;
    wrenches_ = {loop_, topic, dds::Qos::kLoop, [this](const wire::Wrench&) { ++answered_; }};
    return Eventually([&] { return poses_.matched_readers() == 1; });
  }
  /// Sends a pose a millisecond until the condition holds.  False after 20 s, and at once if the
  /// server ends the session.
  template <class Condition>
  bool SendUntil(Condition condition) {
    bool ended = false;
    return Eventually([&] {
             Send(NextPose());
             ended = Phase() == palpate_SESSION_ENDED;
             return ended || condition();
           }) &&
           !ended;
  }
  /// Sends until `answers` more came.
  bool Answered(int answers) {
    return SendUntil([this, end = answered_ + answers] { return answered_ >= end; });
  }
  /// Whether the server ended this session because no pose came in time.
  bool lost_to_silence() {
    return Phase() == palpate_SESSION_ENDED &&
           std::string(state_.reason).starts_with("no pose came for more than 100 ms");
  }
  bool Leave() {
    Ask(true);
    const bool left = Eventually([&] { return Phase() == palpate_SESSION_ENDED; });
    poses_ = {};
    wrenches_ = {};
    return left;
  }
  /// A pose 1 mm deep in the cube, with the next number.
  wire::HapticPose NextPose() {
    wire::HapticPose pose{};
    pose.pose_sequence = ++sequence_;
    pose.sample_time_ns = SteadyNanoseconds();
    pose.position_m[1] = 0.030 - kDepth_m;
    pose.orientation_wxyz[0] = 1.0;
    return pose;
  }
  void Send(const wire::HapticPose& pose) { poses_.Write(pose); }
  int answered() const { return answered_; }
  bool uses_shared_memory() const {
    return poses_.uses_shared_memory() && wrenches_.uses_shared_memory();
  }

 private:
  void Ask(bool leave) { requests_.Write(MakeRequest(name_, run_, scene_, "", leave)); }
  wire::SessionPhase Phase() {
    wire::SessionState state;
    while (states_.Take(state)) {
      if (state.run == run_) state_ = state;
    }
    return state_.run == run_ ? state_.phase : palpate_SESSION_REFUSED;
  }

  std::string name_;
  std::string scene_;
  std::uint64_t run_ = 0, sequence_ = 0;
  std::atomic<int> answered_{0};
  wire::SessionState state_{};
  dds::Participant loop_;
  dds::Participant service_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::SessionRequest> requests_{service_, dds::kSessionRequestTopic,
                                              dds::Qos::kSession};
  dds::Reader<wire::SessionState> states_{service_, dds::kSessionStateTopic, dds::Qos::kSession};
  dds::Writer<wire::HapticPose> poses_;
  dds::Reader<wire::Wrench> wrenches_;
};

}  // namespace palpate::test
