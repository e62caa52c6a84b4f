// palpate-bench loop: round trip from pose to wrench through the real server, compared with a bare
// echo of the same samples over the same transport.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <memory>
#include <optional>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <time.h>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/realtime.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/support/program.h"
#include "tests/support/roudi.h"

namespace palpate::bench {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kLate_us = 1000.0;
constexpr int kBlock = 500;           // ticks in a row to the same peer
constexpr int kKeepAlive = 25;        // between the other's poses: 100 ms of silence end a session
constexpr int kWarmUpBlocks = 2;      // one each: not counted
constexpr milliseconds kSettle{100};  // early samples leak chunks (common/dds/README.md)
/// The same for both paths, whose topics differ by the run.
constexpr const char* kStation = "bench";

struct LoopOptions {
  std::string transport = "shm";
  double seconds = 20.0;
  std::string scene = "cube";
  std::string realtime = "prefer";
  std::string authority;  // a folder that deploy/security/identities made; empty: not secured
  int domain = dds::kMaxDomain;
  std::string json;
};

struct EchoOptions {
  std::string transport;
  std::string realtime;
  std::string identity;
  int domain = 0;
  std::uint64_t run = 0;
};

dds::Network NetworkOf(const std::string& identity) {
  dds::Network network;
  network.identity = identity;
  return network;
}

std::string IdentityOf(const std::string& authority, const std::string& name) {
  return authority.empty() ? "" : authority + "/identities/" + name;
}

dds::Participant LoopDomain(int domain, const std::string& transport, const std::string& realtime,
                            const dds::Network& network) {
  const dds::TransportChoice choice = dds::ChooseTransport(dds::ParseTransport(transport), network);
  EnterRealtime({.mode = ParseRealtimeMode(realtime)});
  dds::Participant participant = dds::Participant::Loop(domain, choice, network);
  LeaveRealtime();
  return participant;
}

template <class Condition>
void Await(const std::string& what, Condition condition) {
  for (int i = 0; i < 10'000; ++i) {
    if (condition()) return;
    std::this_thread::sleep_for(milliseconds(1));
  }
  throw Error("loop: " + what + " did not come within 10 s");
}

/// A station's two loop topics with one peer, and the time of each answer.
class Path {
 public:
  Path(const dds::Participant& participant, std::string station, std::size_t most)
      : participant_(participant), station_(std::move(station)), round_trip_us_(most, -1.0) {
    step_us_.resize(most, 0.0);
    counted_.resize(most, false);
  }

  /// Waits for the peer's endpoints of that run.
  void Open(std::uint64_t run) {
    wrenches_ = {};
    const std::uint64_t asked_before = sequence_;
    const std::string wrench_topic = dds::WrenchTopic(station_, run);
    poses_ = {participant_, dds::PoseTopic(station_, run), dds::Qos::kLoop};
    Await("the writer of " + wrench_topic,
          [&] { return dds::WriterDiscovered(participant_, wrench_topic); });
    wrenches_ = {participant_, wrench_topic, dds::Qos::kLoop,
                 [this](const wire::Wrench& wrench) { OnWrench(wrench); }};
    Await("a reader of poses", [&] { return poses_.matched_readers() > 0; });
    std::this_thread::sleep_for(kSettle);
    // The peer answers once its own wait is over; until then poses keep it awake.
    Await("the first answer of " + station_, [&] {
      Send({}, false);
      return answered_.load() > asked_before;
    });
  }

  void Send(const std::optional<Pose>& pose, bool counted) {
    if (sequence_ + 1 >= counted_.size()) return;
    if (pose) wire::FromPose(*pose, sample_.position_m, sample_.orientation_wxyz);
    sample_.pose_sequence = ++sequence_;
    counted_[sequence_] = counted;
    sample_.sample_time_ns = SteadyNanoseconds();
    poses_.Write(sample_);
  }

  bool uses_shared_memory() const {
    return poses_.uses_shared_memory() && wrenches_.uses_shared_memory();
  }

  struct Figures {
    std::vector<double> round_trip_us, step_us;
    std::size_t lost = 0;
    double late_fraction = 0.0;
  };
  /// Returns the times of the counted poses.  Call it when no answer is in transit.
  Figures Evaluate() {
    wrenches_ = {};
    Figures figures;
    std::size_t late = 0, counted = 0;
    for (std::size_t i = 1; i <= sequence_; ++i) {
      if (!counted_[i]) continue;
      ++counted;
      if (round_trip_us_[i] < 0.0) {
        ++figures.lost;
        continue;
      }
      late += round_trip_us_[i] > kLate_us;
      figures.round_trip_us.push_back(round_trip_us_[i]);
      figures.step_us.push_back(step_us_[i]);
    }
    if (counted > 0) {
      figures.late_fraction =
          static_cast<double>(late + figures.lost) / static_cast<double>(counted);
    }
    return figures;
  }

 private:
  /// Called in DDS's receiving thread.
  void OnWrench(const wire::Wrench& wrench) noexcept {
    const std::int64_t now_ns = SteadyNanoseconds();
    const std::uint64_t i = wrench.pose_sequence;
    if (i >= round_trip_us_.size()) return;
    round_trip_us_[i] = 1e-3 * static_cast<double>(now_ns - wrench.pose_time_ns);
    step_us_[i] = 1e6 * wrench.step_time_s;
    answered_.store(i);
  }

  const dds::Participant& participant_;
  std::string station_;
  wire::HapticPose sample_{};
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> answered_{0};
  std::vector<double> round_trip_us_, step_us_;  // by sequence
  std::vector<bool> counted_;
  dds::Writer<wire::HapticPose> poses_;
  dds::Reader<wire::Wrench> wrenches_;
};

/// The session with the server to which the poses go.
class ServerSession {
 public:
  ServerSession(int domain, const dds::Network& network, std::string scene, Path& path)
      : service_(dds::Participant::Service(domain, network)),
        requests_(service_, dds::kSessionRequestTopic, dds::Qos::kSession),
        states_(service_, dds::kSessionStateTopic, dds::Qos::kSession),
        scene_(std::move(scene)),
        path_(path) {}

  void Begin() {
    wire::SessionRequest request{};
    wire::FromText(kStation, request.station);
    request.run = run_ = RandomRun();
    wire::FromText(scene_, request.scene);
    wire::FromText("palpate-bench loop", request.device);
    requests_.Write(request);
    Await("the server's answer", [&] { return Holds(); });
    path_.Open(run_);
  }

  /// Returns false before the session has begun, and after the server has ended it (the machine may
  /// have stalled for longer than the server waits).
  bool Holds() {
    wire::SessionState state;
    while (states_.Take(state)) {
      if (state.run == run_) state_ = state;
    }
    if (state_.run == run_ && state_.phase == palpate_SESSION_REFUSED) {
      throw Error(std::string("loop: the server refuses: ") + state_.reason);
    }
    return state_.run == run_ && state_.phase != palpate_SESSION_ENDED;
  }

 private:
  dds::Participant service_;
  dds::Writer<wire::SessionRequest> requests_;
  dds::Reader<wire::SessionState> states_;
  std::string scene_;
  Path& path_;
  std::uint64_t run_ = 0;
  wire::SessionState state_{};
};

void SleepUntil(std::int64_t time_ns) {
  const timespec until{time_ns / 1'000'000'000, time_ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {
  }
}

/// Poses to and fro along the scene's path, without jumps.
class Hand {
 public:
  explicit Hand(std::vector<Pose> poses) : poses_(std::move(poses)) {}
  const Pose& Next() {
    const std::size_t n = poses_.size(), i = at_++ % (2 * n);
    return poses_[i < n ? i : 2 * n - 1 - i];
  }

 private:
  std::vector<Pose> poses_;
  std::size_t at_ = 0;
};

std::unique_ptr<RouDi> RouDiWhereNoneRuns(const std::string& transport) {
  if (transport != "shm" || RouDi::AnotherRuns()) return nullptr;
  Progress("starting iox-roudi ...");
  return std::make_unique<RouDi>();
}

void Run(const LoopOptions& options) {
  const std::unique_ptr<RouDi> roudi = RouDiWhereNoneRuns(options.transport);
  const std::string bin = test::OwnFolder();
  const std::string domain = std::to_string(options.domain);
  const std::uint64_t echo_run = RandomRun();
  std::vector<std::string> serve{
      "--scene",        options.scene, "--transport", options.transport, "--realtime",
      options.realtime, "--domain",    domain,        "--log-level",     "warn"};
  std::vector<std::string> echoes{"echo",       "--transport",    options.transport,
                                  "--realtime", options.realtime, "--domain",
                                  domain,       "--run",          std::to_string(echo_run)};
  if (!options.authority.empty()) {
    for (std::vector<std::string>* arguments : {&serve, &echoes}) {
      arguments->insert(arguments->end(),
                        {"--identity", IdentityOf(options.authority, "bench_server")});
    }
  }
  test::Program server(bin + "/palpate-server", serve);
  test::Program echo(bin + "/palpate-bench", echoes);
  Progress("waiting for the server ...");
  if (!server.Says("ready: ", 120.0)) {
    throw Error("loop: the server does not start:\n" + server.Output());
  }

  const dds::Network network = NetworkOf(IdentityOf(options.authority, kStation));
  dds::Participant loop = LoopDomain(options.domain, options.transport, options.realtime, network);
  const int blocks = kWarmUpBlocks + std::max(2, static_cast<int>(options.seconds * 1000 / kBlock));
  const auto most = static_cast<std::size_t>(blocks) * kBlock + 100'000;
  Path served(loop, kStation, most), echoed(loop, kStation, most);
  ServerSession session(options.domain, network, options.scene, served);
  Hand hand(ScriptPoses(options.scene, std::nullopt));
  served.Send(hand.Next(), false);  // nobody hears it yet; the first ones repeat its pose
  echoed.Open(echo_run);            // first: the server would not wait for it
  session.Begin();

  EnterRealtime({.mode = ParseRealtimeMode(options.realtime)});
  int restarts = 0;
  for (int block = 0; block < blocks; ++block) {
    Progress(fmt::format("{} of {} s ...", block * kBlock / 1000, blocks * kBlock / 1000));
    server.Output();
    for (test::Program* program : {&server, &echo}) {
      if (!program->Runs()) throw Error("loop: its other end has ended:\n" + program->Output());
    }
    if (!session.Holds()) {
      ++restarts;
      session.Begin();
    }
    const bool to_server = block % 2 == 0, counted = block >= kWarmUpBlocks;
    std::int64_t next_ns = SteadyNanoseconds();
    for (int i = 0; i < kBlock; ++i) {
      SleepUntil(next_ns += kTick_ns);
      const Pose& pose = hand.Next();
      (to_server ? served : echoed).Send(pose, counted);
      if (i % kKeepAlive == 0) {
        SleepUntil(next_ns + kTick_ns / 2);
        (to_server ? echoed : served).Send(pose, false);
      }
    }
  }
  LeaveRealtime();
  std::this_thread::sleep_for(kSettle);  // for the last answers

  if (options.transport == "shm" && !(served.uses_shared_memory() && echoed.uses_shared_memory())) {
    throw Error("loop: the samples did not go through shared memory; is RouDi still there?");
  }
  const Path::Figures with = served.Evaluate(), bare = echoed.Evaluate();
  for (test::Program* program : {&server, &echo}) {
    program->Signal(SIGTERM);
    program->Exit();
  }
  Progress("");

  const Percentiles rtt = PercentilesOf(with.round_trip_us);
  const Percentiles bare_rtt = PercentilesOf(bare.round_trip_us);
  const Percentiles step = PercentilesOf(with.step_us);
  if (with.round_trip_us.empty() || bare.round_trip_us.empty()) {
    throw Error("loop: no answers came");
  }
  const double ratio_p50 = rtt.p50 / bare_rtt.p50, ratio_p99 = rtt.p99 / bare_rtt.p99;
  Table table(fmt::format("pose out to wrench in: {}, {}, {} s at 1 kHz, real-time {}",
                          options.scene, options.transport, options.seconds, options.realtime));
  table.Row("through the server", "us", rtt);
  table.Row("bare echo", "us", bare_rtt);
  table.Row("server's step", "us", step);
  table.Line("ratio", fmt::format("p50 {:.3f}, p99 {:.3f}", ratio_p50, ratio_p99));
  table.Line("later than 1 ms",
             fmt::format("{:.5f} ({} lost), bare {:.5f} ({} lost)", with.late_fraction, with.lost,
                         bare.late_fraction, bare.lost));
  if (restarts > 0) table.Line("sessions begun anew", std::to_string(restarts));
  table.Print();
  if (options.json.empty()) return;
  WriteJson(options.json, {{"transport", options.transport},
                           {"scene", options.scene},
                           {"seconds", options.seconds},
                           {"realtime", options.realtime},
                           {"rtt_us", ToJson(rtt)},
                           {"late_fraction", with.late_fraction},
                           {"bare_rtt_us", ToJson(bare_rtt)},
                           {"bare_late_fraction", bare.late_fraction},
                           {"ratio_p50", ratio_p50},
                           {"ratio_p99", ratio_p99},
                           {"server_step_us", ToJson(step)},
                           {"lost", with.lost},
                           {"bare_lost", bare.lost},
                           {"sessions_begun_anew", restarts}});
}

/// The other process of the bare echo: a server without sessions and physics.
void Echo(const EchoOptions& options) {
  StopSignal stop;
  const dds::Participant loop =
      LoopDomain(options.domain, options.transport, options.realtime, NetworkOf(options.identity));
  dds::Writer<wire::Wrench> wrenches(loop, dds::WrenchTopic(kStation, options.run),
                                     dds::Qos::kLoop);
  const std::string pose_topic = dds::PoseTopic(kStation, options.run);
  while (!dds::WriterDiscovered(loop, pose_topic)) {
    if (stop.WaitFor(milliseconds(5))) return;
  }
  std::atomic<bool> open{false};
  wire::Wrench wrench{};
  const dds::Reader<wire::HapticPose> poses(loop, pose_topic, dds::Qos::kLoop,
                                            [&](const wire::HapticPose& pose) {
                                              wrench.pose_sequence = pose.pose_sequence;
                                              wrench.pose_time_ns = pose.sample_time_ns;
                                              if (open.load()) wrenches.Write(wrench);
                                            });
  while (wrenches.matched_readers() == 0) {
    if (stop.WaitFor(milliseconds(5))) return;
  }
  std::this_thread::sleep_for(kSettle);
  open = true;
  while (!stop.WaitFor(std::chrono::seconds(1))) {
  }
}

}  // namespace

void AddLoop(const CommandLine& app, const int& domain) {
  auto options = std::make_shared<LoopOptions>();
  const CommandLine command = app.AddCommand(
      "loop",
      "round trip from pose to wrench through palpate-server\n"
      "Compares it with a bare echo over the same transport, alternating in one run.\n"
      "Starts the server, and for shared memory iox-roudi if none runs.");
  command.Footer("Example: palpate-bench loop --transport shm --seconds 20");
  const auto common = [](const CommandLine& to, std::string& transport, std::string& realtime) {
    Add(to, "--transport", transport, "shm or udp").OneOf({"shm", "udp"});
    Add(to, "--realtime", realtime,
        "real-time scheduling of server, echo and this program: require, prefer or off")
        .OneOf({"require", "prefer", "off"});
  };
  common(command, options->transport, options->realtime);
  Add(command, "--seconds", options->seconds, "duration, of server and echo together").Positive();
  Add(command, "--scene", options->scene, "name in the catalogue, or scene file");
  Add(command, "--authority", options->authority,
      "measure in a secured domain, over UDP: folder made by palpate-identities, with a server "
      "'bench_server' and a station 'bench'")
      .ExistingFolder();
  AddJson(command, options->json);
  command.Run([options, &domain] {
    options->domain = domain;
    Run(*options);
  });

  auto echo = std::make_shared<EchoOptions>();
  const CommandLine peer = app.AddCommand("echo", "peer of loop's bare echo");
  peer.Hide();
  common(peer, echo->transport, echo->realtime);
  Add(peer, "--run", echo->run).Required();
  Add(peer, "--identity", echo->identity);
  peer.Run([echo, &domain] {
    echo->domain = domain;
    Echo(*echo);
  });
}

}  // namespace palpate::bench
