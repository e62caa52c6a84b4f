#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <filesystem>

#include <spdlog/fmt/fmt.h>

#include "client/recorder/file_summary.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "tests/faults/faults.h"

namespace palpate::faults {
namespace {

constexpr int kRounds = 6;

/// Hears the poses of the lab's station, like the recorder.
class Wire {
 public:
  explicit Wire(int domain)
      : service_(dds::Participant::Service(domain)),
        loop_(dds::Participant::Loop(domain, {dds::Transport::kUdp, ""})),
        states_(service_, dds::kSessionStateTopic, dds::Qos::kSession) {
    for (int i = 0; i < 300 && newest_ns_ == 0; ++i) {
      wire::SessionState state{};
      while (states_.Take(state)) {
        if (state.phase != palpate_SESSION_ACTIVE) continue;
        poses_ = {};
        poses_ = {loop_, dds::PoseTopic(state.station, state.run), dds::Qos::kLoop,
                  [this](const wire::HapticPose& pose) noexcept {
                    newest_ns_.store(pose.sample_time_ns, std::memory_order_relaxed);
                  }};
      }
      Wait(0.1);
    }
    if (newest_ns_ == 0) throw Error("no pose of the station is heard on the wire");
  }
  ~Wire() { poses_ = {}; }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  /// When the station sampled the newest pose heard, by its clock.
  std::int64_t newest_ns() const { return newest_ns_.load(std::memory_order_relaxed); }

 private:
  dds::Participant service_, loop_;
  dds::Reader<wire::SessionState> states_;
  std::atomic<std::int64_t> newest_ns_{0};
  dds::Reader<wire::HapticPose> poses_;
};

/// When the last pose in a recording was sampled; 0: there is none.
std::int64_t NewestIn(const std::string& file) {
  RecordingReader reader({file});
  RecordedSample sample{};
  wire::HapticPose pose{};
  std::int64_t newest_ns = 0;
  while (reader.Next(sample)) {
    if (sample.To(pose)) newest_ns = pose.sample_time_ns;
  }
  return newest_ns;
}

}  // namespace

Findings RecorderKilled(int domain) {
  Lab lab(domain);
  lab.StartServer();
  lab.StartStation();
  const Wire wire(domain);
  const std::string before = lab.station->Output();
  std::string lost;
  double most_s = 0.0;
  std::uint64_t messages = 0, missing = 0;
  bool all_begun = true;
  for (int i = 0; i < kRounds; ++i) {
    std::filesystem::remove(lab.recording());
    lab.StartRecorder();
    // At different times between two flushes.
    Wait(2.0 + 0.07 * i);
    const std::int64_t newest_ns = wire.newest_ns();
    lab.recorder->Signal(SIGKILL);
    lab.recorder->Exit();
    const FileSummary summary = Summarise({lab.recording()});
    messages += summary.messages;
    missing += summary.missing;
    const std::int64_t written_ns = NewestIn(lab.recording());
    all_begun &= written_ns != 0;
    const double lost_s = std::max(0.0, 1e-9 * static_cast<double>(newest_ns - written_ns));
    lost += fmt::format("{}{:.2f}", lost.empty() ? "" : ", ", lost_s);
    most_s = std::max(most_s, lost_s);
  }
  return {
      Undisturbed(lab, before),
      {"what it had written is whole", fmt::format("{} messages, {} missing", messages, missing),
       messages > 1000 && missing == 0},
      {"of what was on the wire, the end alone is lost (goal 0.5 s)",
       fmt::format("{} s, {:.2f} s at most", lost, most_s), all_begun},
      lab.JudgeTheHand()};
}

}  // namespace palpate::faults
