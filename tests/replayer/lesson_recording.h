#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "client/replayer/play/timeline.h"
#include "common/dds/cdr_reader.h"
#include "common/recording/recording_reader.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"
#include "tests/support/milliseconds.h"

// A recording of all that can take place, and a viewer of it.
namespace palpate::test {

/// Not a round number, as in real recordings.
constexpr std::int64_t kBegin_ns = 1'700'000'000'123'456'789;

/// Collects samples and writes them by time.
class LessonWriter {
 public:
  template <class T>
  void At(std::int64_t at_ms, const std::string& topic, const T& sample) {
    std::vector<std::uint8_t> cdr;
    dds::ToCdr(sample, cdr);
    samples_.push_back({at_ms, topic, kTypeOf<T>, std::move(cdr)});
  }
  void Tool(std::int64_t at_ms, const std::string& station, std::uint32_t contacts = 0,
            std::uint32_t faults = 0) {
    wire::ToolState tool{};
    wire::FromText(station, tool.station);
    tool.pose_sequence = static_cast<std::uint64_t>(at_ms);
    tool.contacts = contacts;
    tool.faults = faults;
    At(at_ms, dds::kToolStateTopic, tool);
  }
  void Session(std::int64_t at_ms, const std::string& station, std::uint64_t run,
               wire::SessionPhase phase = palpate_SESSION_ACTIVE, std::uint64_t server_run = 77) {
    wire::SessionState state = SampleState(station, run);
    state.phase = phase;
    state.server_run = server_run;
    wire::FromText(phase == palpate_SESSION_ENDED ? "the hand has left" : "", state.reason);
    At(at_ms, dds::kSessionStateTopic, state);
  }
  void Change(std::int64_t at_ms, std::uint64_t number, std::uint64_t server_run = 77) {
    wire::SolidBlock block = SampleBlock(number);
    block.server_run = server_run;
    At(at_ms, dds::kSolidBlockTopic, block);
  }
  void Whole(std::int64_t at_ms, std::uint64_t last_change) {
    wire::SceneWhole whole{};
    wire::FromText("cube", whole.scene);
    whole.server_run = 77;
    whole.last_change = last_change;
    At(at_ms, dds::kSceneWholeTopic, whole);
  }
  void Bundle(std::int64_t at_ms, std::uint64_t server_run = 77) {
    std::vector<std::uint8_t> bytes(500, 9);
    At(at_ms, dds::kSceneBundleTopic, SampleBundle(bytes, "cube", server_run));
  }
  /// Adds bytes that are no sample of `type`.
  void Broken(std::int64_t at_ms, const std::string& topic, RecordedType type) {
    samples_.push_back({at_ms, topic, type, {0, 1, 0}});
  }

  void Write(RecordingOptions options, std::vector<std::string>* files = nullptr) {
    std::ranges::stable_sort(samples_, {}, &Sample::at_ms);
    RecordingWriter writer(std::move(options));
    std::int64_t chunk_ms = 0;
    for (const Sample& sample : samples_) {
      // Chunks are as long as in a real recording.
      if (sample.at_ms - chunk_ms >= 700) {
        writer.Flush();
        chunk_ms = sample.at_ms;
      }
      writer.Add(sample.topic, sample.type, kBegin_ns + sample.at_ms * kMs, sample.cdr);
    }
    writer.Close("");
    if (files != nullptr) *files = writer.files();
  }

 private:
  struct Sample {
    std::int64_t at_ms;
    std::string topic;
    RecordedType type;
    std::vector<std::uint8_t> cdr;
  };
  std::vector<Sample> samples_;
};

/// Twelve seconds: a hand that comes, touches, cuts, fails, is lost for two seconds, ends and
/// comes back at another server; another hand that leaves early; a scene that is made whole.
inline void FillLesson(LessonWriter& lesson) {
  lesson.Bundle(0);
  lesson.Session(0, "hand", 5);
  lesson.Session(200, "other", 6);
  for (std::int64_t at_ms = 0; at_ms < 12'000; at_ms += 20) {
    const bool is_lost = at_ms >= 4000 && at_ms < 6000;
    const bool is_out = at_ms >= 8500 && at_ms < 9200;
    const bool touches = at_ms >= 1500 && at_ms < 2500;
    const std::uint32_t faults = at_ms == 3200 ? kFaultJammed : kFaultNone;
    if (!is_lost && !is_out) lesson.Tool(at_ms, "hand", touches ? 1 : 0, faults);
    if (at_ms >= 200 && at_ms <= 2000) lesson.Tool(at_ms, "other");
  }
  for (std::int64_t at_ms = 0; at_ms < 8500; ++at_ms) {
    lesson.At(at_ms, dds::PoseTopic("hand", 5), SamplePose(static_cast<std::uint64_t>(at_ms)));
  }
  lesson.Session(2010, "other", 6, palpate_SESSION_ENDED);
  for (std::uint64_t number = 1; number <= 3; ++number) {
    lesson.Change(static_cast<std::int64_t>(600 + 500 * number), number);
  }
  lesson.Whole(5000, 3);
  lesson.Change(7000, 4);
  lesson.Session(8500, "hand", 5, palpate_SESSION_ENDED);
  lesson.Bundle(9000, 78);
  lesson.Session(9100, "hand", 7, palpate_SESSION_ACTIVE, 78);
  lesson.Change(9500, 1, 78);
}

inline Timeline TimelineOf(RecordingReader& reader) {
  Timeline timeline;
  RecordedSample sample{};
  while (reader.Next(sample)) timeline.Add(sample, reader.place());
  timeline.Finish();
  return timeline;
}

/// What a viewer knows that takes samples as the gateway and the page do.
class Viewer {
 public:
  using Cdr = std::vector<std::uint8_t>;

  void Hear(RecordedType type, std::span<const std::uint8_t> cdr) {
    const RecordedSample sample{type, nullptr, 0, cdr};
    wire::SessionState session{};
    wire::SolidBlock block{};
    wire::SceneWhole whole{};
    wire::SceneBundle bundle{};
    if (sample.To(session)) {
      if (IsCurrent(session.server_run)) Keep(sample, session.station, 0);
    } else if (sample.To(block)) {
      if (IsCurrent(block.server_run) && block.change > undone_[block.scene]) {
        Keep(sample, block.scene, block.change);
      }
    } else if (sample.To(whole)) {
      if (IsCurrent(whole.server_run) && whole.last_change >= undone_[whole.scene]) {
        Undo(whole.scene, whole.last_change);
        Keep(sample, whole.scene, 0);
      }
    } else if (sample.To(bundle)) {
      if (IsCurrent(bundle.server_run)) Keep(sample, bundle.scene, 0);
      dds::FreeContents(bundle);
    } else if (IsForViewers(type) && !Stays(type)) {
      streams[Timeline::SourceOf(sample)] = Cdr(cdr.begin(), cdr.end());
    }
  }

  std::map<std::tuple<RecordedType, std::string, std::uint64_t>, Cdr> holds;
  std::map<Timeline::Source, Cdr> streams;

 private:
  bool IsCurrent(std::uint64_t server_run) {
    if (server_run == server_run_) return true;
    if (former_.contains(server_run)) return false;
    if (server_run_ != 0) former_[server_run_] = true;
    server_run_ = server_run;
    undone_.clear();
    holds.clear();
    return true;
  }
  void Undo(const std::string& scene, std::uint64_t last) {
    undone_[scene] = last;
    std::erase_if(holds, [&](const auto& entry) {
      const auto& [type, name, number] = entry.first;
      return type == RecordedType::kSolidBlock && name == scene && number <= last;
    });
  }
  void Keep(const RecordedSample& sample, const std::string& name, std::uint64_t number) {
    holds[{sample.type, name, number}] = Cdr(sample.cdr.begin(), sample.cdr.end());
  }

  std::uint64_t server_run_ = 0;
  std::map<std::uint64_t, bool> former_;
  std::map<std::string, std::uint64_t> undone_;
};

/// A viewer that has seen everything from the beginning to a time.
inline Viewer ViewerWhoPlayedTo(RecordingReader& reader, std::int64_t time_ns) {
  Viewer viewer;
  reader.Restart();
  RecordedSample sample{};
  while (reader.Next(sample) && sample.log_time_ns <= time_ns) viewer.Hear(sample.type, sample.cdr);
  return viewer;
}

}  // namespace palpate::test
