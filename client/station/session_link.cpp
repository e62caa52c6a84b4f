#include "client/station/session_link.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "client/station/served_tools.h"
#include "common/dds/phase_name.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// From the match to the first sample: the other end may notice the match a little later, and over
/// shared memory a sample from a writer that the reader does not know yet leaks a chunk.
constexpr std::int64_t kSettle_ns = 100'000'000;
/// From the last sample to the writer's end.  Cyclone DDS drops samples whose writer is known to be
/// gone, so a reader (a recorder) would lose the last poses that it has not taken yet.
constexpr std::chrono::milliseconds kLastTaken{100};
/// After this time without a match, the session is requested anew, under a new run.
constexpr std::int64_t kMatchPatience_ns = 5 * kSecond_ns;
/// After this time without a recorder, it is said.
constexpr std::int64_t kRecorderPatience_ns = 3 * kSecond_ns;
constexpr std::int64_t kSilence_ns = kSecond_ns;
constexpr std::int64_t kAskAgain_ns = 2 * kSecond_ns;
/// Readers that may receive nothing in one run before the transport is blamed.
constexpr int kReadersPerRun = 3;
/// A server that refuses a station it has served before may still hold its former session.
constexpr std::int64_t kRefusalPatience_ns = 10 * kSecond_ns;

}  // namespace

SessionLink::SessionLink(LinkOptions options, ReplyRing& replies,
                         const std::function<ServoThread&()>& make_servo_thread, Say say)
    : options_(std::move(options)),
      replies_(replies),
      say_(std::move(say)),
      choice_(dds::ChooseTransport(options_.transport, options_.network)) {
  // DDS's receiving threads and the loop, made in this scope, inherit the real-time rights.
  realtime_ = EnterRealtime(options_.realtime);
  loop_.emplace(dds::Participant::Loop(options_.domain, choice_, options_.network));
  servo_ = &make_servo_thread();
  LeaveRealtime();

  service_.emplace(dds::Participant::Service(options_.domain, options_.network));
  requests_ = {*service_, dds::kSessionRequestTopic, dds::Qos::kSession};
  states_.emplace(*service_, dds::kSessionStateTopic, dds::Qos::kRecordSession);
  Ask(SteadyNanoseconds());
}

SessionLink::~SessionLink() {
  // Leaves at once: after 100 ms without a pose the server would take the station for cut off.
  servo_->SetPath(nullptr);
  const bool held = state_ && !IsOver(*state_);
  WriteRequest(true);
  for (int i = 0; held && i < 30 && state_->phase != palpate_SESSION_ENDED; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    TakeStates();
  }
  Close();
}

void SessionLink::WriteRequest(bool leave) {
  wire::SessionRequest request{};
  wire::FromText(options_.station, request.station);
  request.run = run_;
  wire::FromText(options_.scene, request.scene);
  wire::FromText(options_.tool, request.tool);
  wire::FromText(options_.device, request.device);
  request.leave = leave;
  std::ranges::copy(leave_key_, request.leave_key);
  std::ranges::copy(dds::SealOf(request.leave_key), request.leave_seal);
  if (!leave) std::ranges::fill(request.leave_key, 0);
  request.keeps_scene = options_.keeps_scene;
  requests_.Write(request);
}

void SessionLink::Close() {
  servo_->SetPath(nullptr);
  if (phase_ == Phase::kLinked) std::this_thread::sleep_for(kLastTaken);
  wrenches_ = {};
  path_.reset();
}

void SessionLink::Ask(std::int64_t now_ns) {
  // A run without replies would keep the station's name for seconds, and the new request would wait
  // for it, so it leaves.  A run with replies is silent by now, and the server ends it as cut off,
  // which it remembers for a scene with wear.
  const bool replied = phase_ == Phase::kLinked && servo_->newest_reply_ns() >= phase_since_ns_;
  if (run_ != 0 && !replied) WriteRequest(true);
  Close();
  if (server_restarted_) former_servers_.insert(server_run_);
  run_ = RandomRun();
  leave_key_ = dds::NewLeaveKey();
  server_run_ = 0;
  server_restarted_ = false;
  others_heard_ = false;
  state_.reset();
  readers_made_ = 0;
  matched_since_ns_ = 0;
  phase_ = Phase::kAsking;
  phase_since_ns_ = asked_ns_ = now_ns;
  WriteRequest(false);
}

void SessionLink::TakeStates() {
  dds::CdrSample raw;
  wire::SessionState state{};
  while (states_->Take(raw, state)) {
    if (options_.station != state.station) continue;
    if (IsForeign(raw.origin)) {
      if (!others_heard_) {
        say_(
            "another program imitates this station's server, and is ignored while the server "
            "answers");
      }
      others_heard_ = true;
      continue;
    }
    if (state.run == run_) {
      state_ = state;
      state_origin_ = raw.origin;
    } else if (state_ && state.server_run == server_run_ &&
               state.phase != palpate_SESSION_REFUSED) {
      // DDS keeps only the last state of each name, so the end of this run's session may
      // be overwritten.
      state_->phase = palpate_SESSION_ENDED;
      wire::FromText("another station took the name", state_->reason);
    }
    if (server_run_ != 0 && state.server_run != server_run_) server_restarted_ = true;
  }
}

bool SessionLink::IsForeign(std::uint64_t origin) const {
  // The server that answers poses holds the session.  Others may also publish under the station's
  // name and run, which are public.  A successor is accepted once the server has gone or fallen
  // silent: a killed server counts as alive until its lease ends.
  return phase_ == Phase::kLinked && !silence_said_ && origin != server_origin_ &&
         states_->Hears(server_origin_);
}

void SessionLink::Poll(std::int64_t now_ns) {
  TakeStates();
  if (const bool muted = state_ ? state_->muted : muted_; muted != muted_) {
    muted_ = muted;
    servo_->Mute(muted);
    say_(muted ? "muted: forces are off until a person at the server's gateway unmutes this station"
               : "no longer muted: forces ramp in");
  }
  switch (phase_) {
    case Phase::kAsking:
      return PollAsking(now_ns);
    case Phase::kMatching:
      return PollMatching(now_ns);
    case Phase::kLinked:
      return PollLinked(now_ns);
  }
}

void SessionLink::PollAsking(std::int64_t now_ns) {
  if (!state_) {
    const double asked_s = 1e-9 * static_cast<double>(now_ns - phase_since_ns_);
    if (links_ == 0 && asked_s > options_.patience_s) {
      throw Error(HearsAnotherVersion()
                      ? AnotherVersionIsThere(options_.domain)
                      : NobodyAnswers(options_.domain, options_.network, options_.scene));
    }
    // A server flooded with requests answers only some of them.
    if (AskAgain(now_ns) && asked_s > options_.patience_s) {
      if (HearsAnotherVersion()) throw Error(AnotherVersionIsThere(options_.domain));
      ProbeSharedMemory(now_ns);
    }
    return;
  }
  if (state_->phase == palpate_SESSION_HELD) {
    if (!held_said_) say_(std::string("the session is held: ") + state_->reason);
    held_said_ = true;
    AskAgain(now_ns);  // the server drops a station that stops asking
    return;
  }
  held_said_ = false;
  if (state_->phase == palpate_SESSION_REFUSED) {
    const std::string refusal = std::string("the server refuses the session: ") + state_->reason;
    if (links_ == 0 ||
        (refused_since_ns_ != 0 && now_ns - refused_since_ns_ > kRefusalPatience_ns)) {
      throw Error(refusal);
    }
    if (refused_since_ns_ == 0) {
      refused_since_ns_ = now_ns;
      say_(refusal + "; asking again for 10 s");
    }
    if (now_ns - phase_since_ns_ > kSecond_ns) Ask(now_ns);
    return;
  }
  if (state_->phase == palpate_SESSION_ENDED) return Ask(now_ns);
  refused_since_ns_ = 0;
  if (former_servers_.contains(state_->server_run)) {
    throw Error("two servers run in domain " + std::to_string(options_.domain) +
                ": end one of them, or give it and its stations another --domain");
  }
  server_run_ = state_->server_run;
  server_origin_ = state_origin_;
  tool_ = state_->tool;
  path_ = std::make_unique<PosePath>();
  path_->spring = {state_->stiffness_N_per_m, state_->torsional_stiffness_Nm_per_rad,
                   wire::ToVec3(state_->tool_reference_m)};
  if (!Try(
          [&] {
            path_->writer = {*loop_, dds::PoseTopic(options_.station, run_), dds::Qos::kLoop};
          },
          now_ns)) {
    return;
  }
  phase_ = Phase::kMatching;
  phase_since_ns_ = now_ns;
}

bool SessionLink::AskAgain(std::int64_t now_ns) {
  if (now_ns - asked_ns_ <= kAskAgain_ns) return false;
  asked_ns_ = now_ns;
  WriteRequest(false);
  return true;
}

void SessionLink::ProbeSharedMemory(std::int64_t now_ns) {
  if (!loop_->shared_memory()) return;
  Try([this] { dds::Writer<wire::HapticPose>(*loop_, "palpate/probe", dds::Qos::kLoop); }, now_ns);
}

bool SessionLink::HearsAnotherVersion() const {
  return (states_->matched_writers() == 0 || requests_.matched_readers() == 0) &&
         dds::WriterDiscovered(*service_, dds::kSessionStateTopic);
}

void SessionLink::MakeReader() {
  wrenches_ = {};  // ends the former reader first: two would hold chunks of the same writer
  wrenches_ = {*loop_, dds::WrenchTopic(options_.station, run_), dds::Qos::kLoop,
               [this](const wire::Wrench& sample) noexcept {
                 replies_.Push(ToReply(sample, SteadyNanoseconds()));
               }};
  ++readers_made_;
}

void SessionLink::PollMatching(std::int64_t now_ns) {
  if (server_restarted_ || IsOver(*state_)) return Ask(now_ns);
  // Asked only while it has to be: it goes through all writers of the domain.
  const auto discovered = [this] {
    return dds::WriterDiscovered(*loop_, dds::WrenchTopic(options_.station, run_));
  };
  if (!wrenches_ && discovered() && !Try([this] { MakeReader(); }, now_ns)) return;
  const int readers = path_->writer.matched_readers();
  if (!wrenches_ || readers == 0) {
    if (now_ns - phase_since_ns_ <= kMatchPatience_ns) return;
    if (wrenches_ && wrenches_.matched_writers() == 0 && discovered()) {
      throw Error(AnotherVersionIsThere(options_.domain));
    }
    say_("the server accepted 5 s ago and is not found in the loop's domain: asking again");
    return Ask(now_ns);
  }
  // Forces depend on all poses since the first: a recording without it, or without its answer,
  // cannot be verified.
  if (options_.awaits_recorder && matched_since_ns_ == 0 &&
      (readers == 1 || state_->listeners < 2)) {
    AskAgain(now_ns);  // the server ends a session of which it hears nothing
    if (!recorder_missed_ && now_ns - phase_since_ns_ > kRecorderPatience_ns) {
      say_("no recorder was found within 3 s: waiting for it");
      recorder_missed_ = true;
    }
    return;
  }
  if (matched_since_ns_ == 0) matched_since_ns_ = now_ns;
  if (now_ns - matched_since_ns_ < kSettle_ns) return;

  servo_->SetPath(path_.get());
  phase_ = Phase::kLinked;
  phase_since_ns_ = silent_since_ns_ = now_ns;
  silence_said_ = false;
  say_(links_++ == 0 ? "session: tool '" + tool_ + "' of scene '" + options_.scene + "'"
                     : "session resumed: forces ramp in");
}

void SessionLink::PollLinked(std::int64_t now_ns) {
  // The other server answers poses, too: forces of two servers must not alternate.
  if (others_heard_ && wrenches_.matched_writers() > 1) server_restarted_ = true;
  if (server_restarted_) {
    say_("the server was restarted: asking for the session again");
    return Ask(now_ns);
  }
  if (state_->phase == palpate_SESSION_ENDED) {
    say_(std::string("the server ended the session (") + state_->reason + "): asking again");
    return Ask(now_ns);
  }
  if (servo_->newest_reply_ns() > silent_since_ns_) {
    silent_since_ns_ = servo_->newest_reply_ns();
    if (silence_said_) say_("replies come again: forces ramp in");
    silence_said_ = false;
  }
  if (now_ns - silent_since_ns_ > kSilence_ns) OnSilence(now_ns);
}

void SessionLink::OnSilence(std::int64_t now_ns) {
  silent_since_ns_ = now_ns;
  if (!silence_said_) say_("no replies for 1 s: forces are zero until they come again");
  silence_said_ = true;
  // Asks under a new run, since the other server's answer to this one was ignored.  A server
  // without a writer has no session of this run any more, even if its message about that was lost.
  if (others_heard_ || wrenches_.matched_writers() == 0) return Ask(now_ns);
  if (readers_made_ < kReadersPerRun) {
    Try([this] { MakeReader(); }, now_ns);
    return;
  }
  const bool never_heard = servo_->newest_reply_ns() < phase_since_ns_;
  if (never_heard && MayFallBack()) {
    return FallBackToUdp("connected over shared memory, but nothing arrives", now_ns);
  }
  Ask(now_ns);
}

bool SessionLink::MayFallBack() const {
  return options_.transport == dds::Transport::kAuto && loop_->shared_memory();
}

bool SessionLink::Try(const std::function<void()>& make_endpoints, std::int64_t now_ns) {
  try {
    make_endpoints();
    return true;
  } catch (const Error& error) {
    if (!MayFallBack()) throw;
    FallBackToUdp(error.what(), now_ns);
    return false;
  }
}

void SessionLink::FallBackToUdp(const std::string& why, std::int64_t now_ns) {
  Close();
  loop_.reset();
  choice_ = {dds::Transport::kUdp, "UDP (" + why + ")"};
  EnterRealtime(options_.realtime);
  loop_.emplace(dds::Participant::Loop(options_.domain, choice_, options_.network));
  LeaveRealtime();
  say_("transport: " + choice_.reason);
  Ask(now_ns);
}

std::string SessionLink::PhaseText() const {
  if (phase_ == Phase::kAsking) {
    if (held_said_) return "held";
    return links_ > 0 ? "asking again" : "asking";
  }
  if (phase_ == Phase::kMatching) return "matching";
  if (silence_said_) return "no replies";
  if (muted_) return "muted";
  switch (state_->phase) {
    case palpate_SESSION_ACQUIRING:
      return "tool starts inside";
    case palpate_SESSION_ACTIVE:
      return "active";
    default:
      return "waiting";
  }
}

}  // namespace palpate
