#include "client/replayer/score/score.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/replayer/score/criteria.h"
#include "client/replayer/score/score_report.h"
#include "client/replayer/score/score_words.h"
#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/math/rotation.h"
#include "common/program/stop_signal.h"
#include "common/recording/recording_reader.h"
#include "tests/common/recording/samples.h"
#include "tests/replayer/cut_recording.h"
#include "tests/support/approved.h"
#include "tests/support/complaint.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// A hand that moves 100 mm along x in `seconds`, `side` beside the line, with this force.
HandPath Stroke(double seconds, const Vec3& side = Vec3::Zero(), double force_N = 1.0) {
  HandPath path;
  const int n = static_cast<int>(1000 * seconds);
  for (int i = 0; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    path.time_s.push_back(1e-3 * i);
    path.X_WH.push_back({Vec3(0.1 * s, 0, 0) + side, Quat::Identity()});
    path.force_N.push_back(Vec3(0, 0, force_N));
    path.torque_Nm.push_back(Vec3::Zero());
  }
  return path;
}

TEST(Score, IsNothingBetweenAPathAndItself) {
  const Score score = ScorePath(Stroke(2.0), Stroke(2.0));
  EXPECT_EQ(score.path_max_mm, 0.0);
  EXPECT_EQ(score.frechet_mm, 0.0);
  EXPECT_EQ(score.force_rms_N, 0.0);
  EXPECT_EQ(score.turn_mean_deg, 0.0);
  EXPECT_EQ(score.expert_s, score.trainee_s);
}

TEST(Score, IsTheDistanceOfParallelPathsWhateverTheirPace) {
  const Score score = ScorePath(Stroke(2.0), Stroke(5.0, Vec3(0, 0.003, 0.004)));
  EXPECT_NEAR(score.path_mean_mm, 5.0, 0.01);
  EXPECT_NEAR(score.path_max_mm, 5.0, 0.1);
  EXPECT_NEAR(score.frechet_mm, 5.0, 0.01);
  EXPECT_NEAR(score.trainee_s / score.expert_s, 2.5, 0.02);
}

TEST(Score, SeesADetourByItsGreatestDistance) {
  HandPath detour = Stroke(2.0);
  for (std::size_t i = 0; i < detour.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(detour.size() - 1);
    detour.X_WH[i].p.y() = 0.020 * std::sin(std::numbers::pi * s);
  }
  const Score score = ScorePath(Stroke(2.0), detour);
  EXPECT_NEAR(score.frechet_mm, 20.0, 0.1);
  EXPECT_NEAR(score.path_max_mm, 20.0, 0.5);
  EXPECT_LT(score.path_mean_mm, 15.0);
}

TEST(Score, ComparesForcesAndRotations) {
  HandPath turned = Stroke(2.0, Vec3::Zero(), 1.5);
  for (Pose& X : turned.X_WH) X.q = RotationExp(Vec3(0, 0, 0.1));
  const Score score = ScorePath(Stroke(2.0, Vec3::Zero(), 1.0), turned);
  EXPECT_NEAR(score.force_rms_N, 0.5, 1e-12);
  EXPECT_EQ(score.expert_peak_N, 1.0);
  EXPECT_EQ(score.trainee_peak_N, 1.5);
  EXPECT_NEAR(score.turn_mean_deg, 0.1 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(score.trainee_contact_s, score.trainee_s, 0.01);
}

TEST(Score, TellsTheTimeOfTheGentlestContact) {
  HandPath gentle = Stroke(1.0, Vec3::Zero(), 0.0);
  for (std::size_t i = 500; i < 800; ++i) gentle.force_N[i].z() = 0.03;
  const Score score = ScorePath(gentle, Stroke(1.0, Vec3::Zero(), 0.0));
  EXPECT_NEAR(score.expert_contact_s, 0.3, 1e-9);
  EXPECT_EQ(score.trainee_contact_s, 0.0);
}

/// A power of two, so that times and their sums are exact.
constexpr double kStep_s = 1.0 / 1024;

void Put(HandPath& path, const Pose& X_WH, double force_N) {
  path.time_s.push_back(path.time_s.empty() ? 0.0 : path.time_s.back() + kStep_s);
  path.X_WH.push_back(X_WH);
  path.force_N.push_back(Vec3(0, force_N, 0));
  path.torque_Nm.push_back(Vec3::Zero());
}

void Hold(HandPath& path, int steps, double force_N) {
  const Pose X_WH = path.X_WH.back();
  for (int i = 0; i < steps; ++i) Put(path, X_WH, force_N);
}

/// A hand that goes from place to place and turns, and presses at some places or on the way.
HandPath AnyHand(Random& random) {
  HandPath path;
  Pose at;
  for (int leg = 1 + random.Below(4); leg > 0; --leg) {
    const bool stays = random.Below(3) == 0;
    const Vec3 way = stays ? Vec3(Vec3::Zero()) : Vec3(random.Uniform(-0.1, 0.1), 0, 0.02);
    const Vec3 turn(0, stays ? 0.0 : random.Uniform(-0.5, 0.5), 0);
    const double force_N = random.Below(2) == 0 ? 0.0 : random.Uniform(0.06, 3.0);
    const int steps = 1 + random.Below(200);
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      Put(path, {at.p + share * way, RotationExp(share * turn) * at.q}, force_N);
    }
    at = path.X_WH.back();
  }
  Hold(path, random.Below(50), 0.0);
  return path;
}

bool Acts(const HandPath& path) {
  const Pose& first = path.X_WH.front();
  int acts = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    acts += path.touches(i) || (path.X_WH[i].p - first.p).norm() > 0.01;
  }
  return acts > 1;
}

TEST(Trial, IsTheSameWhateverTheHandWaitsBeforeAndAfter) {
  Random random(1);
  int tried = 0;
  while (tried < 20) {
    const HandPath hand = AnyHand(random);
    if (!Acts(hand)) continue;
    ++tried;
    HandPath waiting;
    Put(waiting, hand.X_WH.front(), 0.0);
    Hold(waiting, random.Below(300), 0.0);
    for (std::size_t i = 0; i < hand.size(); ++i) {
      Put(waiting, hand.X_WH[i], hand.force_N[i].norm());
    }
    Hold(waiting, random.Below(300), 0.0);
    const HandPath a = TrialIn(hand, "a"), b = TrialIn(waiting, "b");
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_EQ(a.force_N, b.force_N);
    const HandPath expert = Stroke(0.1);
    const Score of_a = ScorePath(expert, a), of_b = ScorePath(expert, b);
    const auto numbers = NumbersOf(of_a), again = NumbersOf(of_b);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(numbers[i].second, again[i].second) << numbers[i].first;
    }
    Criteria criteria;
    criteria.criteria = {
        {.name = "soft", .why = {}, .measure = "force_over_share", .limit_N = 0.5}};
    const auto grade_a = GradeTrial(criteria, of_a, a), grade_b = GradeTrial(criteria, of_b, b);
    ASSERT_EQ(grade_a.has_value(), grade_b.has_value());
    if (grade_a) {
      EXPECT_EQ(grade_a->marks[0].value, grade_b->marks[0].value);
    }
  }
}

TEST(Trial, HoldsEveryContact) {
  Random random(2);
  const auto contacts = [](const HandPath& path) {
    return std::ranges::count_if(path.force_N, [](const Vec3& f) { return f.norm() > 0.0; });
  };
  for (int i = 0; i < 100; ++i) {
    const HandPath hand = AnyHand(random);
    if (!Acts(hand)) continue;
    EXPECT_EQ(contacts(TrialIn(hand, "a")), contacts(hand));
  }
}

TEST(Trial, EndsWithAPressOfAHandThatHasArrived) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    HandPath hand = AnyHand(random);
    hand.force_N.assign(hand.size(), Vec3::Zero());
    Put(hand, {hand.X_WH.back().p + Vec3(0.02, 0, 0), Quat::Identity()}, 0.0);
    const int steps = 1 + random.Below(200);
    Hold(hand, steps, 0.9);
    const HandPath trial = TrialIn(hand, "a");
    const Score score = ScorePath(Stroke(0.1), trial);
    EXPECT_EQ(score.trainee_peak_N, 0.9);
    EXPECT_EQ(score.trainee_contact_s, steps * kStep_s);
    EXPECT_EQ(trial.X_WH.back().p, hand.X_WH.back().p);
  }
}

TEST(Trial, MayBeAPressOrATurnAlone) {
  HandPath press;
  Put(press, Pose{}, 0.0);
  EXPECT_THROW(TrialIn(press, "a"), Error);
  Hold(press, 1000, 0.0);
  EXPECT_THROW(TrialIn(press, "a"), Error);
  HandPath turn = press;
  Hold(press, 512, 0.9);
  Hold(press, 1000, 0.0);
  EXPECT_EQ(TrialIn(press, "a").duration_s(), 511 * kStep_s);
  for (int i = 1; i <= 100; ++i) Put(turn, {Vec3::Zero(), RotationExp(Vec3(0, 0, 0.01 * i))}, 0.0);
  EXPECT_NEAR(TrialIn(turn, "a").duration_s(), 98 * kStep_s, 1e-12) << "from 1 to 99 of 100";
}

wire::HapticPose StandingPose(std::uint64_t sequence) {
  wire::HapticPose pose = SamplePose(sequence);
  pose.orientation_wxyz[0] = 1.0;
  for (int k = 1; k < 4; ++k) pose.orientation_wxyz[k] = 0.0;
  return pose;
}

std::string Complaint(const std::string& file, const std::string& station) {
  return ComplaintOf([&] { ReadHandPath({file}, {station}); });
}

TEST(HandPath, IsThatOfTheOnlySessionThatHasPoses) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap"});
  for (std::uint64_t i = 1; i <= 20; ++i) {
    Add(writer, dds::PoseTopic("hand", 2), StandingPose(i), 0);
    if (i != 7) Add(writer, dds::WrenchTopic("hand", 2), SampleWrench(i), 0);
  }
  Add(writer, dds::kSessionStateTopic, SampleState("hand", 2), 0);
  Add(writer, dds::kSessionStateTopic, SampleState("gone", 1), 0);
  writer.Close("");
  const HandPath path = ReadHandPath({folder / "a.mcap"});
  EXPECT_EQ(path.station, "hand");
  EXPECT_EQ(path.scene, "cube");
  ASSERT_EQ(path.size(), 20u);
  EXPECT_NEAR(path.duration_s(), 0.019, 1e-12);
  EXPECT_EQ(path.X_WH[3].p.x(), 0.5);
  EXPECT_EQ(path.force_N[3].x(), 0.5);
  EXPECT_EQ(path.force_N[6], Vec3::Zero());
}

TEST(HandPath, IsAskedForWhereSeveralSessionsHavePoses) {
  const Folder folder;
  const std::string file = folder / "class.mcap";
  RecordingWriter writer({.file = file});
  const std::pair<std::string, std::uint64_t> sessions[] = {{"anna", 1}, {"ben", 2}, {"ben", 3}};
  for (const auto& [station, run] : sessions) {
    const auto from = static_cast<std::int64_t>(2'000'000'000 * run);
    Add(writer, dds::kSessionStateTopic, SampleState(station, run), from);
    for (std::uint64_t i = 1; i <= 10 * run; ++i) {
      Add(writer, dds::PoseTopic(station, run), StandingPose(i),
          from + static_cast<std::int64_t>(100'000'000 * i));
    }
  }
  writer.Close("");
  EXPECT_THAT(Complaint(file, ""),
              HasSubstr("class.mcap: holds 3 sessions; choose one: --station anna (tool ball, from "
                        "0.1 s, 0.9 s long), --station ben/0000000000000002 (tool ball, from 2.1 "
                        "s, 1.9 s long), --station ben/0000000000000003 ("));
  EXPECT_EQ(ReadHandPath({file}, {"anna"}).size(), 10u);
  EXPECT_EQ(ReadHandPath({file}, {"ben/0000000000000003"}).size(), 30u);
  EXPECT_THAT(Complaint(file, "ben"), HasSubstr("holds 2 sessions; choose one: --station ben/"));
  EXPECT_THAT(Complaint(file, "carl"),
              HasSubstr("holds no session of station 'carl'; give one of these: --station anna"));
}

TEST(HandPath, JoinsTheSessionsOfAStationThatLostItsServerAndCameAgain) {
  const Folder folder;
  const std::string file = folder / "a.mcap";
  const auto record = [&](const std::vector<std::string>& stations) {
    RecordingWriter writer({.file = file, .overwrite = true});
    for (std::uint64_t run = 1; run <= stations.size(); ++run) {
      const std::string& station = stations[run - 1];
      const auto from = static_cast<std::int64_t>(2'000'000'000 * run);
      Add(writer, dds::kSessionStateTopic, SampleState(station, run), from);
      for (std::uint64_t i = 1; i <= 10; ++i) {
        wire::HapticPose pose = StandingPose(i);  // counted anew in each session
        pose.sample_time_ns = from + static_cast<std::int64_t>(1'000'000 * i);
        Add(writer, dds::PoseTopic(station, run), pose, pose.sample_time_ns);
      }
      wire::Wrench wrench{};
      wrench.pose_sequence = 4;
      wrench.graphic_orientation_wxyz[0] = 1.0;
      wrench.force_N[0] = static_cast<double>(run);
      Add(writer, dds::WrenchTopic(station, run), wrench, from + 5'000'000);
    }
    writer.Close("");
  };
  record({"anna", "anna"});
  EXPECT_THAT(Complaint(file, ""), HasSubstr("holds 2 sessions"));
  const HandPath path = ReadHandPath({file}, {.joins = true});
  EXPECT_EQ(path.sessions, 2);
  ASSERT_EQ(path.size(), 20u);
  EXPECT_NEAR(path.duration_s(), 2.009, 1e-9);
  EXPECT_EQ(path.force_N[3].x(), 1.0);
  EXPECT_EQ(path.force_N[13].x(), 2.0) << "an answer is its own session's";
  record({"anna", "ben"});
  EXPECT_THROW(ReadHandPath({file}, {.joins = true}), Error) << "two hands are never one";
}

TEST(HandPath, TakesNoWordOfARecordingThatNoArmCouldSay) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap"});
  for (std::uint64_t i = 1; i <= 10; ++i) {
    wire::HapticPose pose = StandingPose(i);
    if (i == 2) pose.pose_sequence = std::numeric_limits<std::uint64_t>::max();
    if (i == 3) pose.sample_time_ns = std::numeric_limits<std::int64_t>::max();
    if (i == 4) pose.position_m[0] = 1e300;
    if (i == 5) pose.sample_time_ns = std::numeric_limits<std::int64_t>::min();
    Add(writer, dds::PoseTopic("hand", 2), pose, 0);
    wire::Wrench wrench = SampleWrench(i);
    if (i == 6) wrench.force_N[1] = 1e300;
    if (i == 7) wrench.torque_Nm[1] = std::numeric_limits<double>::quiet_NaN();
    Add(writer, dds::WrenchTopic("hand", 2), wrench, 0);
  }
  writer.Close("");
  const HandPath path = ReadHandPath({folder / "a.mcap"});
  ASSERT_EQ(path.size(), 6u) << "1 and 6 to 10";
  EXPECT_TRUE(std::ranges::is_sorted(path.time_s));
  EXPECT_EQ(path.force_N[1], Vec3::Zero());
  EXPECT_EQ(path.force_N[2], Vec3::Zero());
  EXPECT_EQ(path.force_N[3].x(), 1.0);
}

TEST(HandPath, LeavesOutPosesThatNobodyCanUse) {
  const Folder folder;
  const auto record = [&](int poses, int usable) {
    RecordingWriter writer({.file = folder / "a.mcap", .overwrite = true});
    for (int i = 1; i <= poses; ++i) {
      wire::HapticPose pose = SamplePose(static_cast<std::uint64_t>(i));
      if (i > usable) {
        for (double& q : pose.orientation_wxyz) q = i % 2 == 0 ? 0.0 : 1.0 / 0.0;
      }
      Add(writer, dds::PoseTopic("hand", 1), pose, 1'000'000 * i);
    }
    writer.Close("");
  };
  record(10, 3);
  EXPECT_EQ(ReadHandPath({folder / "a.mcap"}).size(), 3u);
  record(10, 0);
  EXPECT_THROW(ReadHandPath({folder / "a.mcap"}), Error);
}

using testing::Not;

/// A report on hands so far beside the expert's line and, with `idle`, on one that touches nothing.
Report ReportOf(const std::vector<double>& beside_m, bool idle = false) {
  Report report;
  report.expert = "teacher";
  report.criteria = Criteria{.file = "mine.json", .title = "Strokes", .pass = 60};
  report.criteria->criteria = {{.name = "near",
                                .why = {{"en", "A < B"}},
                                .measure = "path_mean_mm",
                                .best = 0,
                                .worst = 10}};
  const auto add = [&](const std::string& name, const HandPath& path) {
    report.trials.push_back({name, ScorePath(Stroke(2.0), path)});
    report.grades.push_back(GradeTrial(*report.criteria, report.trials.back().score, path));
  };
  for (const double beside : beside_m) {
    add("try " + std::to_string(report.trials.size() + 1), Stroke(2.0, Vec3(0, beside, 0)));
  }
  if (idle) add("idle", Stroke(2.0, Vec3::Zero(), 0.0));
  return report;
}

TEST(Average, IsMeanAndDeviationOfASample) {
  EXPECT_EQ(AverageOf({3.0}).mean, 3.0);
  EXPECT_EQ(AverageOf({3.0}).deviation, 0.0);
  EXPECT_DOUBLE_EQ(AverageOf({1.0, 2.0, 3.0}).mean, 2.0);
  EXPECT_DOUBLE_EQ(AverageOf({1.0, 2.0, 3.0}).deviation, 1.0);
}

/// An expert's cut, a deeper one of a trial, and criteria.
class CutReport : public testing::Test {
 protected:
  CutReport() {
    RecordCut(options.expert, 160, Down(0.8));
    RecordCut(options.trials[0], 250, Down(1.3));
    std::ofstream(options.criteria) << R"({"title": "t", "pass": 50, "criteria": [
      {"name": "over", "measure": "excess_mm3", "best": 0, "worst": 1},
      {"name": "left", "measure": "left_share", "tissue": "enamel", "best": 1, "worst": 0},
      {"name": "walls", "measure": "taper_deg", "best": 0, "worst": 20}]})";
  }
  const Folder folder;
  ScoreOptions options{.expert = folder / "expert.mcap",
                       .trials = {folder / "deeper.mcap"},
                       .criteria = folder / "c.json"};
};

TEST_F(CutReport, MeasuresAndShowsWhatATrialCutBesideTheExpert) {
  const Report report = MakeReport(options);
  ASSERT_EQ(report.pictures.size(), 2u) << "the expert's, too";
  // The same ball half a millimetre deeper removes a cylinder more, but for the bur's lag.
  const double cylinder = 0.25 * std::numbers::pi * 0.5;
  EXPECT_NEAR(report.differences[0].excess_mm3, cylinder, 0.05 * cylinder);
  EXPECT_LT(report.differences[0].missed_mm3, 0.01);
  EXPECT_EQ(report.grades[0]->marks[0].value, report.differences[0].excess_mm3);
  EXPECT_NEAR(*report.grades[0]->marks[1].value,
              report.cuts[0][0].after_mm3 / report.cuts[0][0].before_mm3, 1e-12);
  EXPECT_NEAR(std::ranges::min(report.pictures[1].off), -kMostOff, 0.05e-3);
  const std::string html = ToHtml(report);
  const std::string script = html.substr(html.find("const pictures = ") + 17);
  const auto pictures = nlohmann::json::parse(script.substr(0, script.find(";\n")));
  EXPECT_EQ(pictures[0]["name"], "the expert");
  EXPECT_EQ(pictures[1]["name"], "deeper");
  EXPECT_EQ(pictures[1]["places"].get<std::string>().size(),
            4 * ((6 * report.pictures[1].vertices.size() + 2) / 3));
  EXPECT_THAT(html, HasSubstr("there at the expert’s, and gone"));
}

// A trial scored while it is recorded gets the same score as afterwards, with what Verify computes.
TEST_F(CutReport, FollowsATrialThatIsBeingRecordedToTheSameScore) {
  const std::string whole = options.trials[0], after = ToHtml(MakeReport(options));
  StopSignal stop;
  EXPECT_EQ(ToHtml(MakeReport(options, &stop)), after) << "all of it is there already";

  // As the recorder writes it: the first half, and the rest while the scorer waits.
  const std::string all = ReadWholeFile(whole, 1 << 24);
  std::ofstream grown(folder / "growing.mcap", std::ios::binary);
  grown.write(all.data(), static_cast<std::streamsize>(all.size() / 2)).flush();
  options.trials = {folder / "growing.mcap"};
  std::jthread recorder([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    grown.write(all.data() + all.size() / 2,
                static_cast<std::streamsize>(all.size() - all.size() / 2));
    grown.close();
  });
  const Report report = MakeReport(options, &stop);
  EXPECT_EQ(report.cuts[0][0].after_mm3, MakeReport(options).cuts[0][0].after_mm3);
  const Verification again = Verify({whole}, {.whose = {{"hand", 9}}});
  EXPECT_EQ(report.cuts[0][0].after_mm3, TissuesOf(*again.sessions[0].cut)[0].after_mm3);
}

// What a recorder hears first is how the station's session of another scene has ended.
TEST_F(CutReport, FollowsTheTrialsOwnSessionAndNotTheStationsFormerOne) {
  const std::string whole = options.trials[0];
  const double after = MakeReport(options).cuts[0][0].after_mm3;
  options.trials = {folder / "growing.mcap"};
  RecordingWriter writer({.file = options.trials[0]});
  wire::SessionState former = SampleState("hand", 3);
  former.phase = palpate_SESSION_ENDED;
  Add(writer, dds::kSessionStateTopic, former, 0);
  AddBundle(writer, {1, 2, 3}, 0);
  writer.Flush();
  std::jthread recorder([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    RecordingReader reader({whole});
    for (RecordedSample sample{}; reader.Next(sample);) {
      writer.Add(*sample.topic, sample.type, sample.log_time_ns, sample.cdr);
    }
    writer.Close("");
  });
  StopSignal stop;
  EXPECT_EQ(MakeReport(options, &stop).cuts[0][0].after_mm3, after);
}

TEST(ScoreReport, SaysTheSameInEachLanguage) {
  const auto braces = [](const std::string& text) {
    std::multiset<std::string> names;
    for (std::size_t at = text.find('{'); at != text.npos; at = text.find('{', at + 1)) {
      names.insert(text.substr(at, text.find('}', at) - at));
    }
    return names;
  };
  const auto english = nlohmann::json::parse(kScoreCatalogues.front().second);
  ASSERT_GE(kScoreCatalogues.size(), 3u);
  for (const auto& [tag, words] : kScoreCatalogues) {
    const auto all = nlohmann::json::parse(words);
    EXPECT_EQ(all.size(), english.size()) << tag;
    for (const auto& [key, text] : english.items()) {
      ASSERT_TRUE(all.contains(key)) << tag << ": " << key;
      EXPECT_EQ(braces(all[key]), braces(text)) << tag << ": " << key;
    }
  }
  for (const Measure& measure : kMeasures) {
    EXPECT_TRUE(english.contains("measure." + std::string(measure.name))) << measure.name;
  }
}

/// What a report says to people, on a page without its style and drawings, and to programs.
std::string Said(const std::string& of, const Report& report) {
  const Folder folder;
  WriteReport(report, folder / "report");
  std::string page = ReadWholeFile(folder / "report/score.html");
  for (const std::string tag : {"style", "script", "svg"}) {
    for (std::size_t at; (at = page.find("<" + tag)) != page.npos;) {
      page.erase(at, page.find("</" + tag + ">", at) + tag.size() + 3 - at);
    }
  }
  return "## " + of + "\n" + ToText(report) + page + ReadWholeFile(folder / "report/score.json") +
         "\n";
}

TEST(ScoreReport, IsAsPeopleHaveApproved) {
  // The trials get 90, 70 and 50 points.
  Report three = ReportOf({0.001, 0.003, 0.005});
  EXPECT_NEAR(three.grades[1]->points, 70.0, 0.1);
  std::string said = Said("three trials", three);
  Report named = ReportOf({0.001});
  named.person = "Zoë <O’Brien>";
  named.begun_ns = 1'700'000'000'000'000'000;
  named.criteria->titles = {{"en", "Strokes"}, {"de", "Züge"}};
  named.criteria->criteria[0].names = {{"en", "near"}, {"de", "nahe"}};
  said += Said("one trial of somebody", named);
  said += Said("one trial of two that touches nothing", ReportOf({0.003}, true));
  Report cut = ReportOf({0.001, 0.003});
  cut.expert_cut = {{"caries", 8.0, 0.0}, {"pulp", 70.0, 70.0}};
  cut.cuts = {{{"caries", 8.0, 2.0}, {"pulp", 70.0, 69.5}},
              {{"caries", 8.0, 4.0}, {"pulp", 70.0, 70.0}}};
  said += Said("what was cut", cut);
  Report gated = ReportOf({0.004});
  Criteria& criteria = *gated.criteria;
  criteria.criteria[0].gates = true;  // met to 60 %
  criteria.criteria.push_back(
      {.name = "soft", .why = {}, .measure = "force_peak_N", .best = 1, .worst = 2});
  gated.grades = {GradeTrial(criteria, gated.trials[0].score, Stroke(2.0))};
  said += Said("60 % of the task", gated);
  std::swap(criteria.criteria[0].gates, criteria.criteria[0].harms);
  gated.grades = {GradeTrial(criteria, gated.trials[0].score, Stroke(2.0))};
  said += Said("harm", gated);
  ExpectApproved("tests/replayer/score/report.txt", said);
}

/// The text between a tag and its end.
std::string Inside(const std::string& html, const std::string& tag, const std::string& end) {
  const std::size_t begin = html.find(tag) + tag.size();
  return html.substr(begin, html.find(end, begin) - begin);
}

TEST(ScoreReport, StandsAloneAndLetsNoNameIntoItsMarkup) {
  for (const std::string name :
       {"</script><b>", "x<!--<script>", "a&b\u2028", "-->]]>", "\xff\x1b[2K"}) {
    Report report = ReportOf({0.001});
    report.trials[0].name = report.expert = report.criteria->file = name;
    const std::string html = ToHtml(report);
    const std::string script = Inside(html, "<script>\nconst score = ", ";\n");
    EXPECT_EQ(script.find_first_of("<>&"), script.npos) << name;
    EXPECT_THAT(script, testing::Each(testing::AllOf(testing::Ge(' '), testing::Lt('\x7f'))))
        << name;
    const auto tracks = nlohmann::json::parse(script)["tracks"];
    EXPECT_EQ(tracks[1]["name"], name[0] == '\xff' ? "\ufffd\x1b[2K" : name);
    for (const char* raw : {"</script><b>", "<!--<script>", "]]>", "\xff", "\x1b"}) {
      EXPECT_THAT(html, Not(HasSubstr(raw))) << name;
      EXPECT_THAT(ToSvg(PlotsOf(report.trials)), Not(HasSubstr(raw))) << name;
    }
    EXPECT_THAT(html, HasSubstr("A &lt; B"));
    for (const char* elsewhere : {"src=", "@import", "<link"}) {
      EXPECT_THAT(html, Not(HasSubstr(elsewhere)));
    }
  }
}

TEST(ScoreReport, CallsATrialByItsFileAndStationWhateverTheFileIsCalled) {
  const Folder folder;
  const std::string file = folder / "l\xff<.mcap";
  RecordingWriter writer({.file = file});
  for (const std::string station : {"teacher", "anna"}) {
    Add(writer, dds::kSessionStateTopic, SampleState(station, 1), 0);
    for (std::uint64_t i = 1; i <= 100; ++i) {
      wire::HapticPose pose = SamplePose(i);
      wire::FromPose({Vec3(1e-3 * static_cast<double>(i), 0, 0), Quat::Identity()}, pose.position_m,
                     pose.orientation_wxyz);
      Add(writer, dds::PoseTopic(station, 1), pose, 0);
    }
  }
  writer.Close("");
  ScoreOptions options;
  options.expert = file;
  options.trials = {file};
  EXPECT_THROW(MakeReport(options), Error) << "several sessions";
  options.expert_station = "teacher";
  options.stations = {"anna"};
  const Report report = MakeReport(options);
  EXPECT_EQ(report.trials[0].name, R"(l\xff< (anna))");
  EXPECT_EQ(report.expert, R"(l\xff< (teacher))");
  EXPECT_EQ(report.trials[0].score.path_max_mm, 0.0);
  WriteReport(report, folder / "report");
  EXPECT_GT(std::filesystem::file_size(folder / "report/score.json"), 500u);
}

}  // namespace
}  // namespace palpate::test
