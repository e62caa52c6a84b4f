#include <fstream>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "tests/faults/clock_shim.h"
#include "tests/faults/faults.h"

namespace palpate::faults {
namespace {

constexpr std::int64_t kHour_ns = 3'600'000'000'000;

/// A program's wall clock.
class Clock {
 public:
  Clock(Lab& lab, const std::string& program) : program_(program) {
    const std::string file = lab.folder() / (program + ".clock");
    std::ofstream(file) << std::string(sizeof(SteppedClock), '\0');
    const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
    void* const place =
        mmap(nullptr, sizeof(SteppedClock), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (place == MAP_FAILED) throw Error(file + ": cannot be mapped");
    shared_ = static_cast<SteppedClock*>(place);
    lab.StartWith(program,
                  {"/usr/bin/env", "LD_PRELOAD=" + test::OwnFolder() + "/palpate_clock_shim.so",
                   std::string(kSteppedClockFile) + "=" + file});
  }
  ~Clock() { munmap(shared_, sizeof(SteppedClock)); }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  void Set(std::int64_t ahead_ns) { shared_->ahead_ns = ahead_ns; }
  std::uint64_t asked() const { return shared_->asked; }
  const std::string& program() const { return program_; }

 private:
  std::string program_;
  SteppedClock* shared_ = nullptr;
};

/// Computes the recorded poses once more, in a process whose clock is right: every wrench has the
/// same bits.  The hand cannot judge that: where a busy machine holds a reply up, its force fades
/// for a moment, and it sinks in and comes back.
Finding NoWrenchChanges(const std::string& file) {
  Finding finding{"no wrench is another than with a right clock", "", false};
  test::Program replay(test::OwnFolder() + "/palpate-replay", {"--verify", file});
  finding.held = replay.Exit(120.0) == 0 &&
                 replay.Output().find(" verified, bit for bit") != std::string::npos;
  finding.found = replay.Output().substr(0, replay.Output().find('\n'));
  return finding;
}

Finding IsReadInOrder(const std::string& file) {
  RecordingReader reader({file});
  RecordedSample sample{};
  std::int64_t last_ns = 0, first_ns = 0;
  std::uint64_t messages = 0, back = 0;
  for (; reader.Next(sample); ++messages) {
    if (first_ns == 0) first_ns = sample.log_time_ns;
    back += sample.log_time_ns < last_ns;
    last_ns = sample.log_time_ns;
  }
  const FileSummary summary = Summarise({file});
  const double span_s = 1e-9 * static_cast<double>(last_ns - first_ns);
  return {"the recording is readable and ordered",
          fmt::format("{} messages in {}, {} back in time, {} missing{}", messages, Seconds(span_s),
                      back, summary.missing, summary.complete ? "" : ", without its end"),
          messages > 1000 && back == 0 && summary.missing == 0 && summary.complete &&
              summary.problems.empty() && span_s < 600.0};
}

}  // namespace

Findings ClockSteps(int domain) {
  Lab lab(domain);
  Clock server(lab, "palpate-server"), station(lab, "palpate-station"),
      gateway(lab, "palpate-viewer"), recorder(lab, "palpate-record");
  lab.StartServer();
  lab.StartGateway();
  lab.StartRecorder();
  lab.StartStation();
  Wait(3.0);
  const std::string before = lab.station->Output();
  Findings findings;
  for (Clock* const clock : {&server, &station, &gateway, &recorder}) {
    for (const std::int64_t ahead_ns : {kHour_ns, std::int64_t{0}, -kHour_ns, std::int64_t{0}}) {
      clock->Set(ahead_ns);
      Wait(1.0);
      lab.station->Output();
    }
    findings.push_back({"the clock of " + clock->program() + " steps",
                        fmt::format("asked for {} times meanwhile", clock->asked()),
                        clock->asked() > 0});
    findings.push_back(Shows("the gateway shows the scene", lab));
  }
  findings.push_back(Undisturbed(lab, before));
  findings.push_back(LoopRuns(lab));
  findings.push_back(EndsInOrder("the recorder", *lab.recorder));
  findings.push_back(IsReadInOrder(lab.recording()));
  findings.push_back(NoWrenchChanges(lab.recording()));
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

}  // namespace palpate::faults
