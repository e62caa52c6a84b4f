#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "client/station/display.h"
#include "client/station/pose_lead.h"
#include "client/station/reply.h"
#include "client/station/statistics_period.h"
#include "common/math/rotation.h"
#include "common/step_fault.h"
#include "tests/support/approved.h"
#include "tests/support/milliseconds.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

Reply Numbered(std::uint64_t n) {
  Reply reply;
  reply.pose_sequence = n;
  reply.wrench.force = Vec3::Constant(static_cast<double>(n));
  return reply;
}

TEST(ReplyRing, GivesRepliesInTheirOrderAndRefusesWhatDoesNotFit) {
  ReplyRing ring;
  Reply reply;
  EXPECT_FALSE(ring.Pop(reply));
  for (std::uint64_t n = 0; n < ReplyRing::kCapacity; ++n) EXPECT_TRUE(ring.Push(Numbered(n)));
  EXPECT_FALSE(ring.Push(Numbered(0)));
  for (std::uint64_t n = 0; n < ReplyRing::kCapacity; ++n) {
    ASSERT_TRUE(ring.Pop(reply));
    EXPECT_EQ(reply.pose_sequence, n);
  }
  EXPECT_FALSE(ring.Pop(reply));
  EXPECT_TRUE(ring.Push(Numbered(1)));
}

TEST(ReplyRing, CarriesWholeRepliesBetweenTwoThreads) {
  constexpr std::uint64_t kReplies = 100'000;
  ReplyRing ring;
  std::thread producer([&ring] {
    for (std::uint64_t n = 1; n <= kReplies;) {
      if (ring.Push(Numbered(n))) {
        ++n;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t n = 1; n <= kReplies;) {
    Reply reply;
    if (!ring.Pop(reply)) {
      std::this_thread::yield();
      continue;
    }
    wrong += reply.pose_sequence != n || reply.wrench.force.z() != static_cast<double>(n);
    ++n;
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
}

StationSnapshot Quarter(int i) {
  StationSnapshot s;
  s.time_ns = 250'000'000ll * (i + 1);
  s.ticks = 250;
  s.replies = 200;
  s.sent = 250u * static_cast<unsigned>(i + 1);
  s.late = static_cast<unsigned>(i);
  s.limiter.calls = 250u * static_cast<unsigned>(i + 1);
  s.limiter.braked = 3u * static_cast<unsigned>(i + 1);
  s.silence_s_max = i == 2 ? 0.012 : 0.001;
  s.peak_force_N = i == 6 ? 4.0 : 1.0;
  s.status = 1u << i;
  s.energy_J = 0.1 * i;
  return s;
}

TEST(StatisticsPeriod, SumsTheSnapshotsOfASecond) {
  StatisticsPeriod period("hand", "an arm");
  std::vector<wire::StationStatistics> given;
  for (int i = 0; i < 9; ++i) {
    if (const auto figures = period.Add(Quarter(i), i >= 5 ? 7 : 0, 42)) given.push_back(*figures);
  }
  ASSERT_EQ(given.size(), 2u);
  const wire::StationStatistics& second = given[1];
  EXPECT_STREQ(second.station, "hand");
  EXPECT_STREQ(second.device, "an arm");
  EXPECT_EQ(second.run, 42u);
  EXPECT_DOUBLE_EQ(second.period_s, 1.0);
  EXPECT_EQ(second.ticks, 1000u);
  EXPECT_EQ(second.replies, 800u);
  EXPECT_EQ(second.sent, 1000u);
  EXPECT_EQ(second.late, 4u);
  EXPECT_EQ(second.missed_ticks, 7u);
  EXPECT_EQ(second.braked, 12u);
  EXPECT_EQ(second.silence_s_max, 0.001);
  EXPECT_EQ(given[0].silence_s_max, 0.012);
  EXPECT_EQ(second.applied_force_N_max, 4.0);
  EXPECT_EQ(second.device_status, (1u << 5) | (1u << 6) | (1u << 7) | (1u << 8));
  EXPECT_DOUBLE_EQ(second.energy_J, 0.8);
}

TEST(StatisticsPeriod, EndsWithARunSoThatItsSumsAreTheRuns) {
  StatisticsPeriod period("hand", "an arm");
  std::uint64_t ticks = 0, braked = 0;
  for (int i = 0; i < 7; ++i) {
    const auto figures = period.Add(Quarter(i), 0, 1, i == 6);
    if (!figures) continue;
    ticks += figures->ticks;
    braked += figures->braked;
  }
  EXPECT_EQ(ticks, Quarter(6).limiter.calls);
  EXPECT_EQ(braked, Quarter(6).limiter.braked);
}

TEST(StatisticsPeriod, CountsFromZeroWhereTotalsWereRestarted) {
  StatisticsPeriod period("hand", "an arm");
  for (int i = 0; i < 5; ++i) period.Add(Quarter(i), 0, 1);
  StationSnapshot restarted = Quarter(12);
  restarted.sent = 30;
  restarted.limiter.braked = 50;
  const auto figures = period.Add(restarted, 0, 1);
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->sent, 30u);
  EXPECT_EQ(figures->braked, 35u);
}

/// A lead that has long heard of this round trip.
PoseLead After(double round_trip_s) {
  PoseLead lead;
  for (int i = 0; i < 1000; ++i) lead.Hear(round_trip_s);
  return lead;
}

/// The last of `poses` at a steady pace, as led.
Pose AtSteadyPace(PoseLead lead, const Vec3& v, const Vec3& w, int poses = 20) {
  Pose led;
  for (int i = 0; i < poses; ++i) {
    led = lead.Lead(i * kMs, {1e-3 * i * v, RotationExp(1e-3 * i * w)});
  }
  return led;
}

TEST(PoseLead, IsNoneForAServerOnThisHost) {
  const Vec3 v(0.1, 0.2, 0.0);
  EXPECT_EQ(AtSteadyPace(After(0.5e-3), v, Vec3::Zero()).p, 0.019 * v);
  EXPECT_EQ(AtSteadyPace(After(PoseLead::kNear_s), v, Vec3::Zero()).p, 0.019 * v);
  EXPECT_EQ(AtSteadyPace(PoseLead(), v, Vec3::Zero()).p, 0.019 * v) << "nothing is known of it";
}

TEST(PoseLead, IsWhereASteadyHandIsWhenTheReplyIsHeldAndBlendedIn) {
  const Vec3 v(0.1, -0.05, 0.02), w(0.3, 0.2, -0.5);
  const Pose led = AtSteadyPace(After(0.010), v, w);
  const double then_s = 0.019 + 0.010 + PoseLead::kHeld_s;
  EXPECT_LT((led.p - then_s * v).norm(), 1e-9);
  EXPECT_LT(RotationLog(led.q * RotationExp(then_s * w).conjugate()).norm(), 1e-9);
}

TEST(PoseLead, GrowsWithTheRoundTripWithoutAJump) {
  double last = 0.0;
  for (double round_trip = 0.0; round_trip < 0.040; round_trip += 1e-5) {
    const double lead = After(round_trip).lead_s();
    EXPECT_GE(lead, last);
    EXPECT_LE(lead - last, 5e-5);
    EXPECT_LE(lead, PoseLead::kMost_s + PoseLead::kHeld_s);
    last = lead;
  }
  EXPECT_NEAR(last, PoseLead::kMost_s + PoseLead::kHeld_s, 1e-9);
}

TEST(PoseLead, NeverGoesFarHoweverFastTheHandIs) {
  const Pose led = AtSteadyPace(After(0.020), Vec3(2, 0, 0), Vec3(0, 20, 0));
  EXPECT_NEAR(led.p.x() - 2 * 0.019, PoseLead::kMost_m, 1e-12);
  EXPECT_NEAR(RotationLog(led.q * RotationExp(Vec3(0, 20 * 0.019, 0)).conjugate()).norm(),
              PoseLead::kMost_rad, 1e-12);
}

TEST(PoseLead, HasNoneUntilTheVelocityIsKnownAndAnewAfterAnotherSession) {
  const Vec3 v(0.1, 0, 0);
  EXPECT_EQ(AtSteadyPace(After(0.010), v, Vec3::Zero(), PoseLead::kWindow).p,
            1e-3 * (PoseLead::kWindow - 1) * v);
  PoseLead lead = After(0.010);
  for (int i = 0; i < 20; ++i) lead.Lead(i * kMs, {1e-3 * i * v, Quat::Identity()});
  lead.Forget();
  EXPECT_EQ(lead.Lead(20 * kMs, {v, Quat::Identity()}).p, v) << "the tool of another scene";
}

/// For a hand at rest whose encoders tremble by a step, the lead magnifies no more than it must.
TEST(PoseLead, MagnifiesAnEncodersStepByNoMoreThanLeadOverWindow) {
  const double step = 20e-6;
  PoseLead lead = After(0.010);
  const double most = lead.lead_s() / (1e-3 * PoseLead::kWindow);
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose X{Vec3(random.Below(2) * step, 0, 0), Quat::Identity()};
    EXPECT_LE((lead.Lead(i * kMs, X).p - X.p).norm(), most * step + 1e-15);
  }
}

TEST(PoseLead, LeavesWhatIsNoNumberToTheServerAndForgetsIt) {
  PoseLead lead = After(0.010);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 20; ++i) lead.Lead(i * kMs, {Vec3::Constant(nan), Quat::Identity()});
  EXPECT_TRUE(std::isnan(lead.Lead(20 * kMs, {Vec3::Constant(nan), Quat::Identity()}).p.x()));
  Pose led;
  for (int i = 21; i < 21 + PoseLead::kWindow + 1; ++i) led = lead.Lead(i * kMs, Pose());
  EXPECT_TRUE(led.p.isZero());
  lead.Hear(nan);
  EXPECT_TRUE(std::isfinite(lead.lead_s()));
}

using testing::HasSubstr;

StationView View() {
  StationView view;
  view.seconds = 12.4;
  view.phase = "active";
  StationSnapshot& s = view.snapshot;
  s.rate_hz = 999.7;
  s.round_trip_us_p50 = 27.4;
  s.round_trip_us_p99 = 64.0;
  s.server_step_us_p50 = 3.14;
  s.replies = 250;
  s.contacts = 4;
  s.force_N = s.peak_force_N = 1.42;
  s.torque_Nm = 0.031;
  s.late = 2;
  s.lost = 1;
  s.activity = "slide";
  return view;
}

TEST(LiveTable, LetsNoServerCommandTheTerminal) {
  StationView view = View();
  view.phase = "refused: a\nready\x1b[2J";
  EXPECT_THAT(LiveTable::Line(view), HasSubstr(R"(refused: a\nready\x1b[2J)"));
  for (const std::string& line : LiveTable(stdout, LiveTable::Style::kLines).Lines(view)) {
    EXPECT_THAT(line, testing::Not(HasSubstr("\x1b[2J")));
  }
}

StationSummary Summary() {
  StationSummary summary;
  summary.station = "hand";
  summary.scene = "cube";
  summary.device = "still";
  summary.transport = "UDP";
  summary.seconds = 2.5;
  summary.linked_ticks_s = 2.0;
  summary.totals.ticks = summary.totals.sent = 1990;
  summary.totals.replies = 1000;
  summary.totals.late = 10;
  summary.totals.contact_replies = 250;
  summary.totals.max_force_N = 3.25;
  summary.limits.force_N = 22.0;
  summary.limits.continuous_torque_Nm = 0.188;
  summary.totals.evaluations = 398;
  summary.totals.beyond_region = 199;
  for (int i = 0; i < 1000; ++i) summary.totals.round_trip.Add(30'000);
  return summary;
}

TEST(StationDisplay, IsAsPeopleHaveApproved) {
  std::string text;
  LiveTable table(stdout, LiveTable::Style::kInPlace);
  const auto show = [&](const std::string& when, const StationView& view) {
    text += "## " + when + "\n" + LiveTable::Line(view) + "\n";
    for (const std::string& line : table.Lines(view)) text += line + "\n";
  };
  StationView view = View();
  show("a moment", view);
  view.snapshot.peak_force_N = 7.0;
  show("more force", view);
  view.snapshot.replies = 0;
  show("no reply", view);
  view.snapshot.fading = true;
  view.snapshot.nominal_hz = 1000.0;
  show("fading", view);
  view.snapshot.rate_hz = 198.0;
  show("fading, because its loop is slow", view);
  view.snapshot.faults = kFaultJammed | kFaultRowsFull;
  view.snapshot.device_at_fault = true;
  show("faults", view);

  StationSummary summary = Summary();
  text += "## the end\n" + ToText(summary) + ToJson(summary) + "\n";
  summary.totals.device_faults = 2;
  summary.totals.device_fault_ticks = 100;
  summary.totals.faults = kFaultJammed;
  text += "## the end, with faults\n" + ToText(summary);
  summary.totals.device_fault_ticks = summary.totals.ticks;
  text += "## the end of a device that was never ready\n" + ToText(summary);
  test::ExpectApproved("tests/station/display.txt", text);
}

}  // namespace
}  // namespace palpate
