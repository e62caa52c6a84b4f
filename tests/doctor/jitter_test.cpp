#include "client/doctor/jitter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate::doctor {
namespace {

using testing::HasSubstr;

/// A second of wake-ups at that lateness, and two more.
Jitter Of(std::int64_t mostly_us, std::int64_t twice_us) {
  Jitter jitter;
  for (int i = 0; i < 998; ++i) jitter.lateness.Add(1000 * mostly_us);
  for (int i = 0; i < 2; ++i) jitter.lateness.Add(1000 * twice_us);
  return jitter;
}

TEST(Jitter, IsFineWhereALoopIsHardlyEverLate) {
  EXPECT_EQ(CheckJitter(Of(5, 60)).status, Status::kOk);
}

TEST(Jitter, IsAWarningWhereAQuarterOfAMillisecondIsGoneOnceASecond) {
  EXPECT_EQ(CheckJitter(Of(5, 250)).status, Status::kWarning);
}

TEST(Jitter, IsAWarningWhereASingleWakeUpMissesItsMillisecond) {
  Jitter jitter;
  for (int i = 0; i < 10'000; ++i) jitter.lateness.Add(5'000);
  EXPECT_EQ(CheckJitter(jitter).status, Status::kOk);
  jitter.lateness.Add(1'500'000);
  jitter.missed = 1;
  const Finding finding = CheckJitter(jitter);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("1 ms were missed"));
}

TEST(Jitter, IsAFaultWhereHalfAMillisecondIsGoneOnceASecond) {
  const Finding finding = CheckJitter(Of(5, 700));
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_NE(finding.remedy, "");
}

TEST(Jitter, IsMeasuredOfEachMillisecondWokenUpForOrMissed) {
  StopSignal stop;
  const Jitter jitter = MeasureJitter(0.3, {}, stop);
  EXPECT_FALSE(jitter.stopped);
  // Not one of 300 is left out: it was woken up for, or missed; the last may be after the end.
  EXPECT_NEAR(static_cast<double>(jitter.lateness.count() + jitter.missed), 299.0,
              2.0 + static_cast<double>(jitter.missed));
}

}  // namespace
}  // namespace palpate::doctor
