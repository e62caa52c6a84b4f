#include "client/doctor/jitter.h"

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

/// Wake-ups that are 5 us late, and then some more.
Finding Check(int wake_ups, std::initializer_list<std::int64_t> late_us, std::uint64_t missed = 0) {
  Jitter jitter{.lateness = {}, .missed = missed};
  for (int i = 0; i < wake_ups; ++i) jitter.lateness.Add(5'000);
  for (const std::int64_t us : late_us) jitter.lateness.Add(1000 * us);
  return CheckJitter(jitter);
}

TEST(Jitter, IsJudgedByWhatIsGoneOfAMillisecondOnceASecondAndByTheWorst) {
  EXPECT_THAT(Check(998, {60, 60}), IsOk());
  EXPECT_THAT(Check(998, {250, 250}), IsWarning());
  EXPECT_THAT(Check(998, {700, 700}), IsFault());
  EXPECT_THAT(Check(10'000, {}), IsOk());
  EXPECT_THAT(Check(10'000, {1500}, 1), IsWarning("1 ms were missed"));
}

TEST(Jitter, IsMeasuredOfEachMillisecondWokenUpForOrMissed) {
  StopSignal stop;
  const Jitter jitter = MeasureJitter(0.3, {}, stop);
  // Not one of 300 is left out: it was woken up for, or missed; the last may be after the end.
  EXPECT_NEAR(static_cast<double>(jitter.lateness.count() + jitter.missed), 299.0,
              2.0 + static_cast<double>(jitter.missed));
}

}  // namespace
}  // namespace palpate::doctor
