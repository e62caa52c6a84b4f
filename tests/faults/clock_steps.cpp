#include "tests/faults/clock_steps.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "common/time/steady_clock.h"
#include "tests/faults/clock_shim.h"
#include "tests/link/silence.h"

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

/// Where a machine that is busy holds a reply up, the force fades for a moment, by which a hand
/// that rests on a face sinks in and comes back: no clock's doing, and not judged.
Finding TheHandFeelsTheSame(const Lab& lab, std::int64_t begin_ns, std::int64_t end_ns) {
  constexpr double kLate_ms = 2.0;
  constexpr std::int64_t kSettles_ns = 300'000'000;
  constexpr std::int64_t kBefore_ns = 1'000'000'000;
  const std::vector<test::TraceRow> rows = test::ReadTrace(lab.folder() / "trace.csv");
  const std::vector<double> silence_ms = test::CountedSilence_ms(rows);
  struct Range {
    double least = std::numeric_limits<double>::infinity(), most = 0.0;
  } before, during;
  double longest_ms = 0.0;
  std::size_t judged = 0;
  std::int64_t late_ns = std::numeric_limits<std::int64_t>::min() / 2;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::int64_t t = rows[i].time_ns;
    if (silence_ms[i] > kLate_ms) late_ns = t;
    if (t < begin_ns - kBefore_ns || t > end_ns) continue;
    if (t >= begin_ns) longest_ms = std::max(longest_ms, silence_ms[i]);
    if (t - late_ns < kSettles_ns) continue;
    judged += t >= begin_ns;
    Range& range = t < begin_ns ? before : during;
    range.least = std::min(range.least, rows[i].applied.force.norm());
    range.most = std::max(range.most, rows[i].applied.force.norm());
  }
  if (before.most == 0.0 || judged == 0) {
    return {"no wrench changes", "not judged: this machine held replies up all the while", true};
  }
  const double slack = 0.05 * before.most;
  return {"no wrench changes",
          fmt::format("{:.3f} to {:.3f} N before, {:.3f} to {:.3f} N at {} ticks while clocks "
                      "step; longest silence {:.0f} ms",
                      before.least, before.most, during.least, during.most, judged, longest_ms),
          during.least >= before.least - slack && during.most <= before.most + slack &&
              before.least > 0.1};
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
  const std::int64_t begin_ns = SteadyNanoseconds();
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
  const std::int64_t end_ns = SteadyNanoseconds();
  findings.push_back(Undisturbed(lab, before));
  findings.push_back(LoopRuns(lab));
  findings.push_back(EndsInOrder("the recorder", *lab.recorder));
  findings.push_back(IsReadInOrder(lab.recording()));
  findings.push_back(lab.JudgeTheHand());
  findings.push_back(TheHandFeelsTheSame(lab, begin_ns, end_ns));
  return findings;
}

}  // namespace palpate::faults
