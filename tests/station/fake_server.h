#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

namespace palpate::test {

/// A server of one scene, "floor", with one tool and a plane z = 0 of 1 N/mm.  Speaks the session's
/// protocol and answers each pose; it can refuse, fall silent, vanish without a word and come back.
class FakeServer {
 public:
  FakeServer(int domain, const dds::TransportChoice& transport);
  /// Vanishes without a word, as if killed.
  ~FakeServer();

  void Refuse(const std::string& reason);

  // What the test makes it do from now on.
  std::atomic<bool> mute{false};             ///< answers no poses
  std::atomic<bool> lies{false};             ///< echoes another time than the pose had
  std::atomic<bool> mutes_station{false};    ///< tells the station to render no force
  std::atomic<bool> holds{false};            ///< every station that asks
  std::atomic<bool> ends_session{false};     ///< once, and says so
  std::atomic<bool> forgets_session{false};  ///< once, as if its message was lost

  // What came from the station.
  std::atomic<std::uint64_t> poses{0}, last_sequence{0};
  std::atomic<std::uint64_t> gaps{0};  ///< poses whose number did not follow the one before
  std::atomic<int> sessions{0};
  std::atomic<bool> left{false};

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
  int listeners_ = 0;
  bool held_ = false;
  const std::uint64_t server_run_;
  std::string refusal_;

  std::atomic<bool> stop_{false};
  std::atomic<bool> refusing_{false};
  std::thread thread_;
};

}  // namespace palpate::test
