#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

namespace palpate::test {

/// A server of one scene, "floor", with one tool: a plane z = 0 of 1 N/mm.  Speaks the session's
/// protocol and answers each pose; it can refuse, fall silent, vanish without a word and come back.
class FakeServer {
 public:
  FakeServer(int domain, const dds::TransportChoice& transport);
  /// Vanishes, as if killed: says nothing.
  ~FakeServer();

  void Refuse(const std::string& reason);
  /// Stops answering poses, or goes on.
  void Mute(bool on) { mute_.store(on); }
  /// Says of each pose another time than it came with.
  void LieAboutTime(bool on) { lie_.store(on); }
  /// Tells the station to render no force, or to render it again.
  void MuteStation(bool on) { station_mute_.store(on); }
  /// Holds whoever asks from now on, or lets the held one begin.
  void Hold(bool on) { hold_.store(on); }
  /// Ends the session in words.
  void EndSession() { end_session_.store(true); }
  /// Ends it without a word: as one whose word was lost.
  void ForgetSession() { forget_session_.store(true); }

  std::uint64_t poses() const { return poses_.load(); }
  std::uint64_t last_sequence() const { return last_sequence_.load(); }
  /// Poses whose number was not one more than that of the one before.
  std::uint64_t gaps() const { return gaps_.load(); }
  int sessions() const { return sessions_.load(); }
  bool left() const { return left_.load(); }

 private:
  void Run();
  void OnRequest(const wire::SessionRequest& request);
  void OnPose(const wire::HapticPose& pose) noexcept;
  void Publish(wire::SessionPhase phase, const std::string& reason);

  dds::Participant loop_;
  dds::Participant service_;
  dds::Writer<wire::SessionState> states_;
  dds::Reader<wire::SessionRequest> requests_;
  dds::Writer<wire::Wrench> wrenches_;
  dds::Reader<wire::HapticPose> pose_reader_;
  wire::SessionRequest request_{};
  bool has_session_ = false;
  bool muted_ = false;
  bool held_ = false;
  const std::uint64_t server_run_;
  std::string refusal_;

  std::atomic<bool> stop_{false};
  std::atomic<bool> mute_{false};
  std::atomic<bool> lie_{false};
  std::atomic<bool> station_mute_{false};
  std::atomic<bool> hold_{false};
  std::atomic<bool> end_session_{false};
  std::atomic<bool> forget_session_{false};
  std::atomic<std::uint64_t> poses_{0};
  std::atomic<std::uint64_t> last_sequence_{0};
  std::atomic<std::uint64_t> gaps_{0};
  std::atomic<int> sessions_{0};
  std::atomic<bool> left_{false};
  std::atomic<bool> refusing_{false};
  std::thread thread_;
};

}  // namespace palpate::test
