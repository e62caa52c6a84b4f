#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "client/station/reply.h"
#include "client/station/servo_thread.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/leave_seal.h"
#include "common/dds/participant.h"
#include "common/program/realtime.h"

namespace palpate {

struct LinkOptions {
  std::string station;
  std::string scene;
  std::string tool;    ///< empty: the scene's only one
  std::string device;  ///< for the server's log
  int domain = 0;
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network;
  RealtimeOptions realtime;
  double patience_s = 10.0;  ///< longest wait for a server's first answer
  /// Sends no pose before a recorder reads the poses and the server's wrenches.
  bool awaits_recorder = false;
  bool keeps_scene = false;  ///< nobody may restore the scene while it has its session
};

/// The station's session with a server.  Requests it, makes the loop's endpoints in the order that
/// shared memory needs, and notices when the server has gone, has returned or no longer receives.
///
///   asking    the request is published (and stays: a server that starts later receives it)
///   matching  accepted; waits until the reader has matched the server's writer, and the pose
///             writer the server's reader
///   linked    the servo thread sends poses
///
/// Each round has its own run number, topics named for it (common/dds/topics.h), and a key without
/// which nobody can end its session (common/dds/leave_seal.h).
/// Thread contract: one thread, not the servo thread.
class SessionLink {
 public:
  enum class Phase { kAsking, kMatching, kLinked };
  using Say = std::function<void(const std::string&)>;

  /// Makes both participants, and calls `make_servo_thread` while the calling thread is real-time.
  /// Throws Error if a transport or a right is missing.
  SessionLink(LinkOptions options, ReplyRing& replies,
              const std::function<ServoThread&()>& make_servo_thread, Say say);
  /// Ends the session, if there is one: waits up to 0.3 s for the server's confirmation.
  ~SessionLink();
  SessionLink(const SessionLink&) = delete;
  SessionLink& operator=(const SessionLink&) = delete;

  /// Call it about a hundred times per second.  Throws Error if the server refuses, if no server
  /// answers the first time, or if two answer, since the hand would be between them.
  void Poll(std::int64_t now_ns);

  Phase phase() const { return phase_; }
  /// Returns the state to display: "asking", "held", "matching", "acquiring", "active", "muted".
  std::string PhaseText() const;
  /// Returns the run number of the present or requested session (SessionRequest.run).
  std::uint64_t run() const { return run_; }
  const std::string& tool() const { return tool_; }  ///< as the server named it
  const dds::TransportChoice& transport() const { return choice_; }
  const RealtimeReport& realtime() const { return realtime_; }
  /// Returns the number of sessions after the first.
  int reconnects() const { return links_ > 0 ? links_ - 1 : 0; }

 private:
  void Ask(std::int64_t now_ns);
  /// Publishes the request again, but not too often.  Returns true if it did.
  bool AskAgain(std::int64_t now_ns);
  /// A server that was killed can leave shared memory locked, and then none can start again.  To
  /// find out makes an endpoint, which ends the process and says what to restart
  /// (SharedMemoryWatch).
  void ProbeSharedMemory(std::int64_t now_ns);
  /// Returns whether a server is present whose sample types differ from this program's.
  bool HearsAnotherVersion() const;
  void TakeStates();
  /// Returns true for an answer from a server other than the living one that holds the session.
  bool IsForeign(std::uint64_t origin) const;
  void PollAsking(std::int64_t now_ns);
  void PollMatching(std::int64_t now_ns);
  void PollLinked(std::int64_t now_ns);
  void OnSilence(std::int64_t now_ns);
  /// Makes endpoints; returns false if shared memory failed and it has requested a session over
  /// UDP instead.
  bool Try(const std::function<void()>& make_endpoints, std::int64_t now_ns);
  bool MayFallBack() const;
  void FallBackToUdp(const std::string& why, std::int64_t now_ns);
  void Close();
  void MakeReader();
  void WriteRequest(bool leave);

  LinkOptions options_;
  ReplyRing& replies_;
  Say say_;
  dds::TransportChoice choice_;
  RealtimeReport realtime_;
  std::optional<dds::Participant> loop_;
  ServoThread* servo_ = nullptr;
  std::optional<dds::Participant> service_;
  dds::Writer<wire::SessionRequest> requests_;
  std::optional<dds::CdrReader<wire::SessionState>> states_;

  Phase phase_ = Phase::kAsking;
  std::int64_t phase_since_ns_ = 0;
  std::int64_t asked_ns_ = 0;
  std::uint64_t run_ = 0;
  dds::LeaveKey leave_key_{};                // of that run
  std::uint64_t server_run_ = 0;             // server_run of the server that accepted
  std::optional<wire::SessionState> state_;  // latest answer to this run
  std::uint64_t state_origin_ = 0;           // participant that sent it
  std::uint64_t server_origin_ = 0;          // participant of the server that accepted
  bool others_heard_ = false;                // other servers besides it, in this run
  bool server_restarted_ = false;
  // By server_run: servers that have gone; ignored from then on.
  std::set<std::uint64_t> former_servers_;
  std::int64_t refused_since_ns_ = 0;
  std::string tool_;
  int links_ = 0;

  std::unique_ptr<PosePath> path_;
  dds::Reader<wire::Wrench> wrenches_;
  std::int64_t matched_since_ns_ = 0;
  std::int64_t silent_since_ns_ = 0;  // latest of: last reply, last reader made, link
  int readers_made_ = 0;              // in this run
  bool silence_said_ = false;
  bool held_said_ = false;
  bool recorder_missed_ = false;
  bool muted_ = false;
};

}  // namespace palpate
