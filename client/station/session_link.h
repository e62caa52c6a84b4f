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
  double patience_s = 10.0;  ///< how long the first answer of a server may take
  /// No pose goes out before a recorder reads it, too: for 3 s.
  bool awaits_recorder = false;
};

/// The station's session with a server: asks for it, makes the loop's endpoints in the order that
/// shared memory needs, and notices when the server has gone, come back or gone deaf.
///
///   asking    the request is out (and stays: a server that starts later gets it)
///   matching  accepted; the reader waits for the server's writer, the poses for its reader
///   linked    poses go out; the servo thread sends them
///
/// Each round has a run number of its own, topics named for it (common/dds/topics.h), and a key
/// without which nobody ends its session (common/dds/leave_seal.h).
/// Thread contract: one thread, not the servo thread.
class SessionLink {
 public:
  enum class Phase { kAsking, kMatching, kLinked };
  using Say = std::function<void(const std::string&)>;

  /// Makes both participants, and the servo thread by `make_servo_thread`, which is called while
  /// the calling thread is real-time.  Throws Error where a transport or a right is missing.
  SessionLink(LinkOptions options, ReplyRing& replies,
              const std::function<ServoThread&()>& make_servo_thread, Say say);
  /// Ends the session, if there is one: waits up to 0.3 s for the server's word.
  ~SessionLink();
  SessionLink(const SessionLink&) = delete;
  SessionLink& operator=(const SessionLink&) = delete;

  /// To be called about a hundred times a second.  Throws Error where the server refuses, where no
  /// server answers the first time, or where two do: the hand would be between them.
  void Poll(std::int64_t now_ns);

  Phase phase() const { return phase_; }
  /// What to show of it: "asking", "held", "matching", "acquiring", "active", "muted".
  std::string PhaseText() const;
  /// Of the session that it has or asks for (SessionRequest.run).
  std::uint64_t run() const { return run_; }
  const std::string& tool() const { return tool_; }  ///< as the server named it
  const dds::TransportChoice& transport() const { return choice_; }
  const RealtimeReport& realtime() const { return realtime_; }
  /// Sessions after the first.
  int reconnects() const { return links_ > 0 ? links_ - 1 : 0; }

 private:
  void Ask(std::int64_t now_ns);
  /// True where it has: not too often.
  bool AskAgain(std::int64_t now_ns);
  /// A server is there with which no word can be exchanged.
  bool HearsAnotherVersion() const;
  void TakeStates();
  /// True for the word of another than the server that holds the session and lives.
  bool IsForeign(std::uint64_t origin) const;
  void PollAsking(std::int64_t now_ns);
  void PollMatching(std::int64_t now_ns);
  void PollLinked(std::int64_t now_ns);
  void OnSilence(std::int64_t now_ns);
  /// Makes endpoints; false where shared memory failed and UDP was taken instead, asked for anew.
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
  std::uint64_t server_run_ = 0;             // of the server that accepted
  std::optional<wire::SessionState> state_;  // latest answer to this run
  std::uint64_t state_origin_ = 0;           // the participant whose it is
  std::uint64_t server_origin_ = 0;          // the participant of the server that accepted
  bool others_heard_ = false;                // beside it, in this run
  bool server_restarted_ = false;
  std::set<std::uint64_t> former_servers_;  // by server_run: one that has gone answers no more
  std::int64_t refused_since_ns_ = 0;
  std::string tool_;
  int links_ = 0;

  std::unique_ptr<PosePath> path_;
  dds::Reader<wire::Wrench> wrenches_;
  std::int64_t matched_since_ns_ = 0;
  std::int64_t silent_since_ns_ = 0;  // last reply, last reader or link: whichever is the latest
  int readers_made_ = 0;              // in this run
  bool silence_said_ = false;
  bool held_said_ = false;
  bool muted_ = false;
};

}  // namespace palpate
