#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "client/doctor/checks.h"
#include "common/dds/endpoint.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/realtime/sleep_until.h"
#include "common/realtime/steady_clock.h"

namespace palpate::doctor {
namespace {

using std::chrono::milliseconds;

constexpr const char* kStation = "palpate_doctor";
constexpr std::int64_t kPeriod_ns = 1'000'000;
constexpr int kPoses = 1000;
constexpr int kMeetWithin_ms = 5000;
// Wait as stations do before their first pose: over shared memory, a reader leaks samples that
// come earlier.
constexpr milliseconds kSettle{100};
constexpr int kAllWithin_ms = 15'000;
// A round trip beyond a millisecond makes a wrench late.  With a thousand wake-ups per second,
// p99.9 is what occurs once a second.  A pose needs some tens of microseconds of its millisecond,
// so it still arrives if half of that is lost, and a station does not age its wrench for a late
// millisecond or two now and then.
constexpr double kGood_us = 100.0;
constexpr double kBearable_us = 500.0;
constexpr double kOneTick_us = 1000.0;

/// Opens a participant with the loop's rights, which its receiving threads inherit.
dds::Participant Open(const LoopOptions& options) {
  const dds::TransportChoice choice = dds::ChooseTransport(options.transport, options.network);
  EnterRealtime(options.realtime);
  dds::Participant participant = dds::Participant::Loop(options.domain, choice, options.network);
  LeaveRealtime();
  return participant;
}

void Await(const char* what, const std::function<bool()>& condition) {
  for (int i = 0; i < kMeetWithin_ms; ++i) {
    if (condition()) return;
    std::this_thread::sleep_for(milliseconds(1));
  }
  throw Error(std::string(what) + " was not found within 5 s");
}

/// Acts as the server: answers in the thread that received the pose, until told to end.
void Echo(const LoopOptions& options, std::uint64_t run, StopSignal& stop) {
  const dds::Participant participant = Open(options);
  dds::Writer<wire::Wrench> wrenches(participant, dds::WrenchTopic(kStation, run), dds::Qos::kLoop);
  const std::string pose_topic = dds::PoseTopic(kStation, run);
  Await("the station", [&] { return dds::WriterDiscovered(participant, pose_topic); });
  const dds::Reader<wire::HapticPose> poses(participant, pose_topic, dds::Qos::kLoop,
                                            [&](const wire::HapticPose& pose) {
                                              wire::Wrench wrench{};
                                              wrench.pose_sequence = pose.pose_sequence;
                                              wrench.pose_time_ns = pose.sample_time_ns;
                                              wrenches.Write(wrench);
                                            });
  while (!stop.WaitFor(kSettle)) {
  }
}

/// Acts as the station.
LoopTrial Ask(const LoopOptions& options, std::uint64_t run, const StopSignal& stop) {
  LoopTrial trial;
  const dds::Participant participant = Open(options);
  dds::Writer<wire::HapticPose> poses(participant, dds::PoseTopic(kStation, run), dds::Qos::kLoop);
  const std::string wrench_topic = dds::WrenchTopic(kStation, run);
  Await("the echo", [&] { return dds::WriterDiscovered(participant, wrench_topic); });
  Histogram round_trip;             // used by the receiving thread until the reader has ended
  std::atomic<bool> counts{false};  // false for the first poses, which find caches cold
  std::atomic<std::uint64_t> first{0};
  dds::Reader<wire::Wrench> wrenches(participant, wrench_topic, dds::Qos::kLoop,
                                     [&](const wire::Wrench& wrench) {
                                       if (!counts || wrench.pose_sequence < first) return;
                                       round_trip.Add(SteadyNanoseconds() - wrench.pose_time_ns);
                                     });
  Await("the echo's reader", [&] { return poses.matched_readers() > 0; });
  Await("the echo's writer", [&] { return wrenches.matched_writers() > 0; });
  std::this_thread::sleep_for(kSettle);
  wire::HapticPose pose{};
  std::int64_t due_ns = SteadyNanoseconds();
  for (int i = -kPoses / 10; i < kPoses && !stop.stopped(); ++i) {
    due_ns += kPeriod_ns;
    SleepUntil(due_ns);
    ++pose.pose_sequence;
    if (i == 0) {
      first = pose.pose_sequence;
      counts = true;
    }
    pose.sample_time_ns = SteadyNanoseconds();
    poses.Write(pose);
  }
  std::this_thread::sleep_for(kSettle);
  trial.shared_memory = poses.uses_shared_memory() && wrenches.uses_shared_memory();
  wrenches = {};  // no callback runs any more
  trial.sent = kPoses;
  trial.lost = trial.sent - std::min(trial.sent, round_trip.count());
  trial.p50_us = 1e-3 * static_cast<double>(round_trip.Quantile(0.5));
  trial.p99_us = 1e-3 * static_cast<double>(round_trip.Quantile(0.99));
  trial.max_us = 1e-3 * static_cast<double>(round_trip.max());
  trial.finished = !stop.stopped();
  return trial;
}

/// Starts a process that does the work and writes its result into the pipe.
pid_t Start(int pipe, const std::function<LoopTrial()>& work) {
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  LoopTrial trial;
  try {
    trial = work();
  } catch (const std::exception& error) {
    std::snprintf(trial.error, sizeof trial.error, "%s", error.what());
  }
  [[maybe_unused]] const auto written = write(pipe, &trial, sizeof trial);
  std::exit(0);  // regular exit, so that iceoryx deregisters from RouDi
}

/// Asks the child to end before killing it: a client killed during a write leaves a lock in RouDi.
void End(pid_t child) {
  if (child <= 0) return;
  kill(child, SIGTERM);
  for (int i = 0; i < 200; ++i) {
    if (waitpid(child, nullptr, WNOHANG) == child) return;
    std::this_thread::sleep_for(milliseconds(10));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

void Loop(std::int64_t end_ns, const std::atomic<bool>& stop, Jitter& jitter) {
  std::int64_t due_ns = SteadyNanoseconds() + kPeriod_ns;
  while (due_ns < end_ns && !stop.load(std::memory_order_relaxed)) {
    SleepUntil(due_ns);
    const std::int64_t late_ns = SteadyNanoseconds() - due_ns;
    jitter.lateness.Add(late_ns);
    const std::int64_t passed = late_ns / kPeriod_ns;
    jitter.missed += static_cast<std::uint64_t>(passed);
    due_ns += (1 + passed) * kPeriod_ns;
  }
}

}  // namespace

LoopTrial TryLoop(const LoopOptions& options, StopSignal& stop) {
  LoopTrial trial;
  int ends[2];
  if (pipe(ends) != 0) return trial;
  std::fflush(nullptr);  // so that the children do not print it again
  const std::uint64_t run = RandomRun();
  const pid_t echo = Start(ends[1], [&] {
    Echo(options, run, stop);
    return LoopTrial{};
  });
  const pid_t station = Start(ends[1], [&] { return Ask(options, run, stop); });
  close(ends[1]);
  // The first to report is the station, or the process that failed.
  pollfd readable{.fd = ends[0], .events = POLLIN, .revents = 0};
  if (poll(&readable, 1, kAllWithin_ms) > 0 &&
      read(ends[0], &trial, sizeof trial) != static_cast<ssize_t>(sizeof trial)) {
    trial = {};
  }
  End(station);
  End(echo);
  close(ends[0]);
  return trial;
}

Finding CheckLoop(const LoopTrial& trial, dds::Transport expected) {
  if (!trial.finished && trial.error[0] == '\0') {
    return Fault("the trial loop hung or crashed",
                 "restart RouDi, server and stations; --log-level debug shows the reason; "
                 "--transport udp needs no RouDi");
  }
  if (!trial.finished) {
    return Fault(trial.error,
                 "fix the findings above, and let UDP through the firewall on this interface");
  }
  const std::string found =
      fmt::format("{}: {:.0f} us round trip, p99 {:.0f}, max {:.0f}; {} of {} lost",
                  trial.shared_memory ? "shared memory" : "UDP", trial.p50_us, trial.p99_us,
                  trial.max_us, trial.lost, trial.sent);
  if (expected == dds::Transport::kSharedMemory && !trial.shared_memory) {
    return Fault(found + "; RouDi answers but is not used",
                 "restart RouDi, server and stations; 'ls -l /dev/shm /tmp/roudi' must show this "
                 "user, or one of its groups");
  }
  const std::string remedy =
      "fix the findings above on rights, cores and kernel, and end other programs";
  if (trial.p99_us > kOneTick_us || 100 * trial.lost > trial.sent) return Fault(found, remedy);
  if (trial.p99_us <= kBearable_us && trial.lost == 0) return Ok(found);
  return Warning(found, remedy + "; " + ShownPlaceOf(ProjectFile::kRealTimePage) +
                            " describes what helps most");
}

Jitter MeasureJitter(double seconds, const RealtimeOptions& realtime, StopSignal& stop) {
  Jitter jitter;
  std::atomic<bool> end{false};
  std::atomic<bool> done{false};
  std::exception_ptr error;
  std::thread thread([&] {
    try {
      EnterRealtime(realtime);
      Loop(SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds), end, jitter);
    } catch (...) {
      error = std::current_exception();
    }
    done = true;
  });
  while (!done && !stop.WaitFor(std::chrono::milliseconds(50))) {
  }
  end = true;
  thread.join();
  if (error) std::rethrow_exception(error);
  return jitter;
}

Finding CheckJitter(const Jitter& jitter) {
  const auto us = [](std::uint64_t ns) { return 1e-3 * static_cast<double>(ns); };
  const double p999_us = us(jitter.lateness.Quantile(0.999));
  const double max_us = us(jitter.lateness.max());
  std::string found =
      fmt::format("a loop is {:.0f} us late once per second, {:.0f} us at most", p999_us, max_us);
  if (jitter.missed > 0) found += fmt::format("; {} ms were missed", jitter.missed);
  if (p999_us <= kGood_us && max_us <= kOneTick_us) return Ok(found);
  constexpr const char* kRemedy =
      "fix the findings above, end other programs ('top' shows the busy ones) and try again; pin a "
      "virtual machine to cores of its own, or use a physical host";
  return p999_us > kBearable_us ? Fault(found, kRemedy) : Warning(found, kRemedy);
}

}  // namespace palpate::doctor
