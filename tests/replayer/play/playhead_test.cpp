#include "client/replayer/play/playhead.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/replayer/lesson_recording.h"

namespace palpate::test {
namespace {

using Heard = std::vector<std::pair<std::int64_t, std::vector<std::uint8_t>>>;

/// In one file, and in splits of some seconds.
class PlayheadTest : public testing::TestWithParam<double> {
 protected:
  PlayheadTest() {
    LessonWriter lesson;
    FillLesson(lesson);
    std::vector<std::string> files;
    lesson.Write({.file = folder_ / "a.mcap", .split_s = GetParam()}, &files);
    EXPECT_EQ(files.size() > 1, GetParam() > 0.0);
    reader_.emplace(files);
    timeline_ = TimelineOf(*reader_);
    reader_->Restart();
    RecordedSample sample{};
    while (reader_->Next(sample)) {
      if (!IsForViewers(sample.type)) continue;
      all_.emplace_back(sample.log_time_ns, std::vector(sample.cdr.begin(), sample.cdr.end()));
    }
  }
  Heard AllAfter(std::int64_t time_ns) const {
    Heard rest;
    for (const auto& sample : all_) {
      if (sample.first > time_ns) rest.push_back(sample);
    }
    return rest;
  }

  Folder folder_;
  std::optional<RecordingReader> reader_;
  Timeline timeline_;
  Heard all_;
};

TEST_P(PlayheadTest, ShowsAndGoesOnAsIfItHadPlayedUpToThere) {
  // There and back: no way depends on the one before.
  for (const std::int64_t at_ms : {0, 11'980, 1500, 5900, 4500, -1, 3000, 8499, 5000, 9000, 8501,
                                   20'000, 2010, 6000, 10'500}) {
    SCOPED_TRACE(at_ms);
    const std::int64_t time_ns = kBegin_ns + at_ms * kMs;
    Playhead again(*reader_, timeline_);
    const Viewer viewer = ViewerWhoPlayedTo(*reader_, time_ns);
    // It reads on where it was left to: all files are known again.
    TimelineOf(*reader_);
    EXPECT_EQ(again.GoTo(time_ns), viewer.streams);
    Heard rest;
    RecordedSample sample{};
    while (again.Next(sample)) {
      EXPECT_EQ(again.passed_ns(), sample.log_time_ns);
      rest.emplace_back(sample.log_time_ns, std::vector(sample.cdr.begin(), sample.cdr.end()));
    }
    EXPECT_EQ(rest, AllAfter(time_ns));
  }
}

INSTANTIATE_TEST_SUITE_P(Files, PlayheadTest, testing::Values(0.0, 3.0));

}  // namespace
}  // namespace palpate::test
