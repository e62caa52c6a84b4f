// Every measure of a motion, computed again from the exported tables alone.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

#include <gmock/gmock.h>

#include "client/replayer/export/export.h"
#include "client/replayer/score/score_report.h"
#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "tests/replayer/export/csv_table.h"
#include "tests/replayer/hand_recording.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

constexpr const char* kFloor =
    R"("region": {"box": {"min_mm": [-4, -6.6, 2], "max_mm": [4, -4.8, 5]}}, )";
const Vec3 kLow(-4e-3, -6.6e-3, 2e-3), kHigh(4e-3, -4.8e-3, 5e-3), kTip(0, 0.2e-3, 0);

/// Each measure of a motion, with and without a region.
std::string CriteriaText() {
  std::string criteria;
  for (const Measure& measure : kMeasures) {
    if (measure.of_cut) continue;
    const std::string name = measure.name;
    const auto add = [&](const std::string& region) {
      criteria += (criteria.empty() ? "" : ", ") + std::string("{\"name\": \"") + name +
                  (region.empty() ? "" : " on the floor") + "\", \"measure\": \"" + name + "\", " +
                  (name == "force_over_share" ? "\"limit_N\": 0.1, " : "") + region +
                  "\"best\": 0, \"worst\": 1}";
    };
    add("");
    if (measure.in_a_place) add(kFloor);
  }
  return R"({"title": "t", "pass": 0, "tip_mm": [0, 0.2, 0], "sites": [
    {"name": "a", "margin_mm": [2.4, 0, 4.75], "into": [0, -1, 0], "radius_mm": 2,
     "depth_mm": 5.5, "tolerance_mm": 0.6},
    {"name": "b", "margin_mm": [9, 0, 4.75], "into": [0, -1, 0], "radius_mm": 2,
     "depth_mm": 5.5, "tolerance_mm": 0.6}], "criteria": [)" +
         criteria + "]}";
}

/// A station's session as its tables have it: the answered rows, all of them or those of the trial.
struct Rows {
  HandPath path;
  explicit Rows(const std::string& folder) {
    const Table poses = ReadCsv(folder + "/poses.csv");
    const Table wrenches = ReadCsv(folder + "/wrenches.csv");
    const auto number = [](const Table& table, std::size_t row, const std::string& name) {
      return std::stod(table.text.at(name).at(row));
    };
    const auto vector = [&](const Table& table, std::size_t row, const std::string& name,
                            const std::string& unit) {
      return Vec3(number(table, row, name + "_x_" + unit), number(table, row, name + "_y_" + unit),
                  number(table, row, name + "_z_" + unit));
    };
    const auto pose = [&](const Table& table, std::size_t row, const std::string& name) {
      return Pose{vector(table, row, name, "m"),
                  Quat(number(table, row, name + "_qw"), number(table, row, name + "_qx"),
                       number(table, row, name + "_qy"), number(table, row, name + "_qz"))};
    };
    std::map<std::string, std::size_t> row_of;
    for (std::size_t i = 0; i < poses.rows(); ++i) row_of[poses.text.at("pose_sequence")[i]] = i;
    for (std::size_t i = 0; i < wrenches.rows(); ++i) {
      const std::size_t row = row_of.at(wrenches.text.at("pose_sequence")[i]);
      path.time_s.push_back(number(poses, row, "station_time_s"));
      path.X_WH.push_back(pose(poses, row, "hand"));
      path.X_WG.push_back(pose(wrenches, i, "tool"));
      path.force_N.push_back(vector(wrenches, i, "force", "N"));
    }
    // The hand moves all the time, so the trial lacks a millimetre at either end at which it is
    // free.
    const auto rests = [&](std::size_t i, std::size_t next, const Pose& end) {
      return path.force_N[i].isZero(0.0) && (path.X_WH[next].p - end.p).norm() <= 1e-3;
    };
    std::size_t first = 0, last = path.size() - 1;
    while (rests(first, first + 1, path.X_WH.front())) ++first;
    while (rests(last, last - 1, path.X_WH.back())) --last;
    const auto cut = [&](auto& all) {
      all.erase(all.begin() + static_cast<std::ptrdiff_t>(last) + 1, all.end());
      all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first));
    };
    cut(path.time_s), cut(path.X_WH), cut(path.X_WG), cut(path.force_N);
    for (const double begin = path.time_s.front(); double& t : path.time_s) t -= begin;
  }
  /// Returns the time of the rows for which something holds.
  double Time(const std::function<bool(std::size_t)>& holds) const {
    double sum_s = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i) {
      if (holds(i)) sum_s += path.time_s[i] - path.time_s[i - 1];
    }
    return sum_s;
  }
  bool OnFloor(std::size_t i) const {
    const Vec3 tip = path.X_WG[i] * kTip;
    return (tip.array() >= kLow.array()).all() && (tip.array() <= kHigh.array()).all();
  }
};

/// The expert's hand at the pocket, of whose poses some are not answered.
class Measures : public testing::Test {
 protected:
  Measures() { std::ofstream(folder / "c.json") << CriteriaText(); }
  void Record(const std::string& name, std::uint64_t lost_of_100,
              std::uint64_t last_answered = 9001) const {
    const Scene scene = LoadScene("periodontal");
    const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
    const PoseScript script =
        PoseScript::Load(PALPATE_SOURCE_DIR "/client/course/exercises/pocket-depth.path.json");
    RecordHand(
        scene, model,
        {.poses = 9001,
         .at = [&](std::uint64_t i) { return script.At(1e-3 * static_cast<double>(i)); },
         .lost =
             [=](std::uint64_t i) { return i % 100 >= 100 - lost_of_100 || i > last_answered; }},
        folder / name);
  }
  Report Scored() const {
    return MakeReport({.expert = folder / "expert.mcap",
                       .trials = {folder / "trial.mcap"},
                       .criteria = folder / "c.json"});
  }
  Rows Exported(const std::string& name) const {
    StopSignal stop;
    Export({.files = {folder / name}, .folder = folder / name + ".csv"}, stop);
    return Rows(folder / name + ".csv/hand_0000000000000009");
  }
  const Folder folder;
};

TEST_F(Measures, AreThoseOfTheExportedTables) {
  Record("expert.mcap", 0);
  Record("trial.mcap", 30);
  const Report report = Scored();
  const Rows trial = Exported("trial.mcap"), expert = Exported("expert.mcap");
  const auto all = [](std::size_t) { return true; };
  const auto on_floor = [&](std::size_t i) { return trial.OnFloor(i); };
  const auto touches = [&](std::size_t i) { return trial.path.force_N[i].norm() > 0.0; };
  const auto over = [&](std::size_t i) { return trial.path.force_N[i].norm() > 0.1; };
  const auto longest_rest = [&](const auto& is_there) {
    double longest_s = 0.0;
    std::size_t begin = 0;  // of the rest; the row before its first
    for (std::size_t i = 1; i < trial.path.size(); ++i) {
      const auto tip = [&](std::size_t row) { return trial.path.X_WG[row] * kTip; };
      const bool rests = touches(i) && is_there(i);
      const bool begins = rests && (begin == 0 || (tip(i) - tip(begin)).norm() > 5e-4);
      if (!rests) begin = 0;
      if (begins) begin = i;
      if (rests) {
        longest_s = std::max(longest_s, trial.path.time_s[i] - trial.path.time_s[begin - 1]);
      }
    }
    return longest_s;
  };
  const auto both = [](const auto& a, const auto& b) {
    return [&](std::size_t i) { return a(i) && b(i); };
  };
  double peak_N = 0.0, deepest_m = 0.0;
  for (std::size_t i = 0; i < trial.path.size(); ++i) {
    peak_N = std::max(peak_N, trial.path.force_N[i].norm());
    const Vec3 tip = trial.path.X_WG[i] * kTip - 1e-3 * Vec3(2.4, 0, 4.75);
    if (touches(i) && std::hypot(tip.x(), tip.z()) <= 2e-3) {
      deepest_m = std::max(deepest_m, -tip.y());
    }
  }
  const Score score = ScorePath(expert.path, trial.path);
  const std::map<std::string, double> values = {
      {"force_over_share", trial.Time(over) / trial.Time(touches)},
      {"force_over_share on the floor",
       trial.Time(both(over, on_floor)) / trial.Time(both(touches, on_floor))},
      {"force_peak_N", peak_N},
      {"force_rms_N", score.force_rms_N},
      {"path_mean_mm", score.path_mean_mm},
      {"path_max_mm", score.path_max_mm},
      {"turn_mean_deg", score.turn_mean_deg},
      {"time_s", trial.Time(all)},
      {"time_s on the floor", trial.Time(on_floor)},
      {"contact_s", trial.Time(touches)},
      {"contact_s on the floor", trial.Time(both(touches, on_floor))},
      {"rest_s", longest_rest(all)},
      {"rest_s on the floor", longest_rest(on_floor)},
      {"time_ratio", trial.Time(all) / expert.Time(all)},
      {"sites_right_share", 0.5 * (std::abs(deepest_m - 5.5e-3) <= 0.6e-3)}};
  ASSERT_EQ(values.size(), report.criteria->criteria.size());
  for (std::size_t c = 0; c < values.size(); ++c) {
    const std::string& name = report.criteria->criteria[c].name;
    EXPECT_NEAR(report.grades[0]->marks[c].value.value(), values.at(name), 1e-9) << name;
  }
  EXPECT_NEAR(1e3 * *report.grades[0]->depths[0], 1e3 * deepest_m, 1e-9);
  EXPECT_GT(values.at("contact_s on the floor"), 0.5) << "it has been there";
  EXPECT_GT(values.at("rest_s on the floor"), 0.2);
  EXPECT_LT(values.at("rest_s on the floor"), values.at("contact_s on the floor"));
  EXPECT_NEAR(values.at("contact_s"), report.trials[0].score.expert_contact_s, 0.2)
      << "time is time, also where nothing was answered";
}

TEST_F(Measures, AreNotOfACompleteTrialIfMoreThanATwentiethIsNotAnswered) {
  Record("expert.mcap", 0);
  Record("trial.mcap", 4);
  EXPECT_TRUE(Passed(Scored()));
  EXPECT_TRUE(Scored().trials[0].incomplete.empty());
  Record("trial.mcap", 7);
  const Report report = Scored();
  ASSERT_FALSE(report.trials[0].incomplete.empty());
  const LocalText& why = report.trials[0].incomplete[0];
  EXPECT_THAT(why.at("en"), testing::HasSubstr("7 %"));
  EXPECT_FALSE(Passed(report)) << "0 points would be enough";
  EXPECT_THAT(ToText(report), testing::HasSubstr(why.at("en")));
  EXPECT_THAT(ToHtml(report), testing::HasSubstr(why.at("de"))) << "in the reader's language";
  Record("trial.mcap", 0, 6000);
  EXPECT_FALSE(Passed(Scored())) << "the server was gone, the hand went on";
}

TEST_F(Measures, AreNotOfACompleteTrialIfItsRecordingIsCutOff) {
  Record("expert.mcap", 0);
  std::filesystem::copy_file(folder / "expert.mcap", folder / "trial.mcap");
  EXPECT_TRUE(Passed(Scored()));
  std::filesystem::resize_file(folder / "trial.mcap",
                               2 * std::filesystem::file_size(folder / "trial.mcap") / 3);
  EXPECT_THAT(EnglishOf(Scored().trials[0].incomplete.at(0)), testing::HasSubstr("cut off"));
  EXPECT_FALSE(Passed(Scored()));
}

}  // namespace
}  // namespace palpate::test
