#include "client/replayer/score/score_report.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "common/error.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A hand along x by 100 mm in 2 s, so far beside the expert's line.
HandPath Stroke(double beside_m, double force_N = 1.0) {
  HandPath path;
  for (int i = 0; i <= 2000; ++i) {
    path.time_s.push_back(1e-3 * i);
    path.X_WH.push_back({Vec3(5e-5 * i, beside_m, 0), Quat::Identity()});
    path.force_N.push_back(Vec3(0, 0, force_N));
    path.torque_Nm.push_back(Vec3::Zero());
  }
  return path;
}

Report ReportOf(const std::vector<double>& beside_m) {
  Report report;
  report.expert = "teacher";
  report.criteria = Criteria{.file = "mine.json", .title = "Strokes", .pass = 60};
  report.criteria->criteria = {
      {.name = "near", .why = "A < B", .measure = "path_mean_mm", .best = 0, .worst = 10}};
  for (const double beside : beside_m) {
    const HandPath path = Stroke(beside);
    report.trials.push_back(
        {"try " + std::to_string(report.trials.size() + 1), ScorePath(Stroke(0), path)});
    report.grades.push_back(GradeTrial(*report.criteria, report.trials.back().score, path));
  }
  return report;
}

Report WithOneThatTouchesNothing(Report report) {
  const HandPath path = Stroke(0.0, 0.0);
  report.trials.push_back({"idle", ScorePath(Stroke(0), path)});
  report.grades.push_back(GradeTrial(*report.criteria, report.trials.back().score, path));
  return report;
}

TEST(Average, IsMeanAndDeviationOfASample) {
  EXPECT_EQ(AverageOf({3.0}).mean, 3.0);
  EXPECT_EQ(AverageOf({3.0}).deviation, 0.0);
  EXPECT_DOUBLE_EQ(AverageOf({1.0, 2.0, 3.0}).mean, 2.0);
  EXPECT_DOUBLE_EQ(AverageOf({1.0, 2.0, 3.0}).deviation, 1.0);
}

TEST(ScoreReport, JudgesByTheAverageOfTheTrials) {
  // 90, 70 and 50 points.
  const Report report = ReportOf({0.001, 0.003, 0.005});
  EXPECT_NEAR(report.grades[1]->points, 70.0, 0.1);
  EXPECT_THAT(ToText(report), HasSubstr("Strokes: 70 ± 20 of 100 points, passed"));
  const std::string html = ToHtml(report);
  EXPECT_THAT(html, HasSubstr("<b>70</b>"));
  EXPECT_THAT(html, HasSubstr("average of 3 trials, ± 20"));
  EXPECT_THAT(html, HasSubstr("<th>try 3</th><th>average</th>"));
  EXPECT_THAT(html, Not(HasSubstr("predicts nothing")));
  EXPECT_THAT(ToHtml(ReportOf({0.003, 0.007})), HasSubstr("not yet"));
}

TEST(ScoreReport, GivesNoPointsToATrialThatTouchesNothing) {
  const Report idle = WithOneThatTouchesNothing(ReportOf({}));
  EXPECT_THAT(ToText(idle), HasSubstr("Strokes: nothing was touched: no points\n"));
  EXPECT_THAT(ToHtml(idle), HasSubstr("nothing was touched: no points"));
  const Report both = WithOneThatTouchesNothing(ReportOf({0.003}));
  EXPECT_THAT(ToText(both), HasSubstr("Strokes: 70 of 100 points, passed"));
  EXPECT_THAT(ToHtml(both), HasSubstr("<b>70</b>"));
  const Folder folder;
  WriteJson(both, folder / "both.json");
  const auto trials = nlohmann::json::parse(std::ifstream(folder / "both.json"))["trials"];
  EXPECT_NEAR(trials[0]["points"], 70.0, 0.1);
  EXPECT_TRUE(trials[1]["points"].is_null());
}

TEST(ScoreReport, SaysThatOneTrialPredictsNothing) {
  const Report report = ReportOf({0.001});
  EXPECT_THAT(ToText(report), HasSubstr("One trial predicts nothing"));
  EXPECT_THAT(ToHtml(report), HasSubstr("One trial predicts nothing"));
}

TEST(ScoreReport, IsWrittenAsAPageWithPlotsAndFigures) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("palpate_report_" + std::to_string(getpid()));
  WriteReport(ReportOf({0.001, 0.003}), folder / "report");
  for (const char* name : {"score.html", "score.svg", "score.json"}) {
    EXPECT_GT(std::filesystem::file_size(folder / "report" / name), 500u) << name;
  }
  std::filesystem::remove_all(folder);
}

/// What is between a tag and its end.
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
