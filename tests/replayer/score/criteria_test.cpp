#include "client/replayer/score/criteria.h"

#include <fstream>
#include <regex>

#include <gmock/gmock.h>

#include "client/course/exercise.h"
#include "client/replayer/score/score_plot.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/refusals.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class CriteriaTest : public testing::Test {
 protected:
  Criteria Load(const std::string& text) {
    std::ofstream(file_) << text;
    return LoadCriteria(file_);
  }
  std::string Complaint(const std::string& text) {
    return ComplaintOf([&] { Load(text); });
  }
  const Folder folder_;
  const std::string file_ = folder_ / "criteria.json";
};

/// A tip that goes straight down to y = -depth and up again in 2 s, with this force, half of it at
/// first.
HandPath Probing(double depth_m, double force_N, double x_m = 0.0) {
  HandPath path;
  for (int i = 0; i <= 2000; ++i) {
    path.time_s.push_back(1e-3 * i);
    const double down = i < 1000 ? 1e-3 * i : 2.0 - 1e-3 * i;
    path.X_WH.push_back({Vec3(x_m, 0.005 - (depth_m + 0.005) * down, 0), Quat::Identity()});
    path.force_N.push_back(Vec3(0, i < 500 ? 0.5 * force_N : force_N, 0));
    path.torque_Nm.push_back(Vec3::Zero());
  }
  return path;
}

TEST_F(CriteriaTest, ThatATeacherBeginsWithGradeAGoodHandFullyAndARoughOneLess) {
  const Criteria criteria = Load(kCriteriaToBeginWith);
  EXPECT_EQ(criteria.title, "Periodontal probing");
  ASSERT_EQ(criteria.sites.size(), 1u);
  EXPECT_NEAR(criteria.criteria[0].limit_N, 0.025 * 9.81, 1e-3);
  const ProbingSite& site = criteria.sites[0];
  const auto probing = [&](double depth_m, double force_N) {
    HandPath path = Probing(depth_m, force_N);
    for (Pose& X : path.X_WH) X.p = site.margin - X.p.y() * site.into;
    return path;
  };
  const HandPath expert = probing(0.006, 0.2), rough = probing(0.009, 1.0);
  const Grade good = *GradeTrial(criteria, ScorePath(expert, expert), expert);
  EXPECT_DOUBLE_EQ(good.points, 100.0);
  EXPECT_NEAR(*good.depths[0], 0.006, 1e-6);
  const Grade bad = *GradeTrial(criteria, ScorePath(expert, rough), rough);
  EXPECT_LT(bad.points, criteria.pass);
  EXPECT_EQ(bad.marks[1].points, 0.0) << "3 mm too deep";
  const HandPath idle = probing(0.006, 0.0);
  EXPECT_FALSE(GradeTrial(criteria, ScorePath(expert, idle), idle)) << "it touches nothing";
}

TEST_F(CriteriaTest, GiveTheShareThatLiesBetweenBestAndWorst) {
  const Criteria criteria = Load(R"({"title": "t", "pass": 50, "criteria": [
    {"name": "gentle", "measure": "force_over_share", "limit_N": 0.75, "best": 0, "worst": 1},
    {"name": "peak", "measure": "force_peak_N", "best": 0, "worst": 4, "weight": 3}]})");
  const HandPath path = Probing(0.006, 1.0);  // 1 N during three quarters of the time
  const Grade grade = *GradeTrial(criteria, ScorePath(path, path), path);
  EXPECT_NEAR(*grade.marks[0].value, 0.75, 1e-3);
  EXPECT_NEAR(grade.marks[0].points, 25.0, 0.1);
  EXPECT_NEAR(grade.marks[1].points, 75.0, 1e-9);
  EXPECT_NEAR(grade.points, (25.0 + 3 * 75.0) / 4, 0.05);
}

TEST_F(CriteriaTest, GradeWhatABurLeftOfEachTissue) {
  const Criteria criteria = Load(R"({"title": "t", "pass": 50, "criteria": [
    {"name": "decay", "measure": "left_share", "tissue": "caries", "best": 0.1, "worst": 0.5},
    {"name": "sound", "measure": "removed_mm3", "tissue": "dentine", "best": 1, "worst": 5}]})");
  EXPECT_TRUE(AsksForCuts(criteria));
  const HandPath path = Probing(0.006, 1.0);
  const Score score = ScorePath(path, path);
  const Grade grade = *GradeTrial(criteria, score, path, [](const Criterion& criterion) {
    return criterion.tissue == "caries" ? std::optional(0.3) : std::nullopt;
  });
  EXPECT_NEAR(*grade.marks[0].value, 0.3, 1e-12);
  EXPECT_NEAR(grade.marks[0].points, 50.0, 1e-9);
  EXPECT_FALSE(grade.marks[1].value) << "there was nothing to measure";
  EXPECT_EQ(grade.marks[1].points, 0.0);
  const SolidsCut none{std::make_shared<Scene>(), nullptr, {}, {}};
  EXPECT_THAT(ComplaintOf([&] {
                MeasureCut(criteria.criteria[0], none, none, CutShape(none), criteria.file);
              }),
              testing::AllOf(HasSubstr("'decay': no tissue that can be cut is named 'caries'"),
                             HasSubstr("the scene has no solid")));
}

TEST_F(CriteriaTest, CountCareOnlyAsFarAsTheTaskIsDone) {
  const Criteria criteria =
      Load(R"({"title": "t", "pass": 50, "gates": ["deep", "long"], "criteria": [
    {"name": "gentle", "measure": "force_peak_N", "best": 1, "worst": 2, "weight": 2},
    {"name": "deep", "measure": "sites_right_share", "best": 1, "worst": 0},
    {"name": "long", "measure": "contact_s", "best": 8, "worst": 0}], "sites": [
    {"name": "a", "margin_mm": [0, 0, 0], "into": [0, -1, 0], "radius_mm": 1, "depth_mm": 6,
     "tolerance_mm": 1},
    {"name": "b", "margin_mm": [9, 0, 0], "into": [0, -1, 0], "radius_mm": 1, "depth_mm": 6,
     "tolerance_mm": 1}]})");
  const HandPath path = Probing(0.006, 1.0);  // one site of two, and 2 s of 8
  const Grade grade = *GradeTrial(criteria, ScorePath(path, path), path);
  EXPECT_NEAR(grade.done, 0.5 * 0.25, 1e-9);
  EXPECT_EQ(grade.marks[0].ungated, 100.0);
  EXPECT_NEAR(grade.marks[0].points, 12.5, 1e-9);
  EXPECT_NEAR(grade.marks[1].points, 50.0, 1e-9);
  EXPECT_NEAR(grade.marks[2].points, 25.0, 1e-9) << "a gate is not gated itself";
  EXPECT_NEAR(grade.points, (2 * 12.5 + 50.0 + 25.0) / 4, 1e-9);
}

TEST_F(CriteriaTest, CountAllElseOnlyAsFarAsNoHarmIsDone) {
  const Criteria criteria =
      Load(R"({"title": "t", "pass": 50, "gates": ["long"], "harms": ["short"], "criteria": [
    {"name": "gentle", "measure": "force_peak_N", "best": 1, "worst": 2, "weight": 2},
    {"name": "long", "measure": "contact_s", "best": 8, "worst": 0},
    {"name": "short", "measure": "contact_s", "best": 0, "worst": 4}]})");
  const HandPath path = Probing(0.006, 1.0);  // 2 s
  const Grade grade = *GradeTrial(criteria, ScorePath(path, path), path);
  EXPECT_NEAR(grade.done, 0.25, 1e-9);
  EXPECT_NEAR(grade.harmless, 0.5, 1e-9);
  EXPECT_NEAR(grade.marks[0].points, 100 * 0.25 * 0.5, 1e-9);
  EXPECT_NEAR(grade.marks[1].points, 25 * 0.5, 1e-9) << "the task does not excuse harm";
  EXPECT_NEAR(grade.marks[2].points, 50 * 0.25, 1e-9) << "nor does care that nothing was done";
  EXPECT_NEAR(grade.points, (2 * 12.5 + 12.5 + 12.5) / 4, 1e-9);
}

TEST_F(CriteriaTest, CountForceAndTimeInAPlace) {
  const Criteria criteria = Load(R"({"title": "t", "pass": 50, "criteria": [
    {"name": "gentle", "measure": "force_over_share", "limit_N": 0.75, "best": 0, "worst": 1,
     "region": {"box": {"min_mm": [-1, -9, -1], "max_mm": [1, 0, 1]}}},
    {"name": "swift", "measure": "time_s", "best": 0, "worst": 2,
     "region": {"sphere": {"centre_mm": [0, -6, 0], "radius_mm": 5.5}}}]})");
  // 11 mm down in a second and up again: below 0 from 0.4545 s on, and with 1 N from 0.5 s on.
  const HandPath path = Probing(0.006, 1.0);
  const Grade grade = *GradeTrial(criteria, ScorePath(path, path), path);
  EXPECT_NEAR(*grade.marks[0].value, (1.0 + 1.0 / 11.0 - (0.5 - 5.0 / 11.0)) / (12.0 / 11.0), 1e-2);
  EXPECT_NEAR(*grade.marks[1].value, 1.0, 1e-2);
}

TEST_F(CriteriaTest, ReadWhatAMeasureIsAbout) {
  const auto with = [](const std::string& more) {
    return R"({"title": "t", "pass": 50, "criteria": [{"name": "a", "best": 0, "worst": 1, )" +
           more + "}]}";
  };
  const Criterion taper = Load(with(R"("measure": "taper_deg", "axis": [0, 0, 2],
                   "region": {"box": {"min_mm": [0, 1, 2], "max_mm": [1, 2, 3]}})"))
                              .criteria[0];
  EXPECT_EQ(taper.axis, Vec3::UnitZ());
  EXPECT_TRUE(taper.place->Holds(Vec3(0.0005, 0.0015, 0.0025)));
}

TEST(ProbingSite, IsAsDeepAsTheTipGotWithinItsRadius) {
  const ProbingSite site{"s", Vec3::Zero(), -Vec3::UnitY(), 0.002, 0.006, 0.001};
  EXPECT_NEAR(*DepthIn(site, Vec3::Zero(), Probing(0.004, 0.1)), 0.004, 1e-6);
  EXPECT_NEAR(*DepthIn(site, Vec3(0, -0.001, 0), Probing(0.004, 0.1)), 0.005, 1e-6);
  EXPECT_FALSE(DepthIn(site, Vec3::Zero(), Probing(0.004, 0.1, 0.003)).has_value());
  EXPECT_FALSE(DepthIn(site, Vec3::Zero(), Probing(-0.001, 0.1)).has_value());
  EXPECT_FALSE(DepthIn(site, Vec3::Zero(), Probing(0.004, 0.0)).has_value()) << "it hovers";
}

TEST(ProbingSite, IsProbedByTheToolAndNotByTheHandThatPressesIt) {
  const ProbingSite site{"s", Vec3::Zero(), -Vec3::UnitY(), 0.002, 0.006, 0.001};
  HandPath path = Probing(0.009, 0.1);
  path.X_WG = Probing(0.006, 0.1).X_WH;
  EXPECT_NEAR(*DepthIn(site, Vec3::Zero(), path), 0.006, 1e-6);
}

TEST_F(CriteriaTest, NameTheFieldThatIsWrong) {
  ExpectRefusals("tests/replayer/score/criteria.refusals",
                 [&](const auto& inputs) { return Complaint(inputs.at(0)); });
}

struct Text {
  double x0, y0, x1, y1;
  std::string words;
};

/// The boxes of a drawing's horizontal texts, as wide as in DejaVu Sans, a wide face.
std::vector<Text> TextsOf(const std::string& svg) {
  static const std::regex kText(
      R"re(<text x="([-.0-9]+)" y="([-.0-9]+)" class="[^"]*" text-anchor="(\w+)" font-size="([.0-9]+)">([^<]*)<)re");
  std::vector<Text> texts;
  for (std::sregex_iterator m(svg.begin(), svg.end(), kText), end; m != end; ++m) {
    const double x = std::stod((*m)[1]), y = std::stod((*m)[2]), font = std::stod((*m)[4]);
    const double w = 0.55 * font * static_cast<double>((*m)[5].length());
    const double x0 = (*m)[3] == "start" ? x : (*m)[3] == "end" ? x - w : x - 0.5 * w;
    texts.push_back({x0, y - 0.75 * font, x0 + w, y, (*m)[5]});
  }
  return texts;
}

ScorePlot Crowded(double greatest) {
  ScorePlot plot{.title = "Crowded", .subtitle = "many trials", .x_title = "s", .y_title = "N"};
  for (int i = 0; i < 9; ++i) {
    plot.lines.push_back({"trial with a name as long as this, number " + std::to_string(i),
                          {0.0, 0.5 * greatest},
                          {0.0, greatest}});
  }
  return plot;
}

TEST(ScorePlot, NeverWritesTextOnText) {
  for (const double greatest : {0.0, 0.0123, 8.7, 123456.0}) {
    const std::vector<Text> texts = TextsOf(ToSvg({Crowded(greatest), Crowded(greatest)}));
    ASSERT_GT(texts.size(), 28u);
    for (std::size_t i = 0; i < texts.size(); ++i) {
      EXPECT_GE(texts[i].x0, 0.0) << texts[i].words;
      EXPECT_LE(texts[i].x1, 960.0) << texts[i].words;
      for (std::size_t j = 0; j < i; ++j) {
        const Text &a = texts[i], &b = texts[j];
        EXPECT_FALSE(a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1)
            << "'" << a.words << "' lies on '" << b.words << "'";
      }
    }
  }
}

TEST(ScorePlot, PlacesValuesBetweenTheTicksThatNameThem) {
  const std::string svg = ToSvg({{.lines = {{"", {0.0, 1.5, 3.0}, {0.0, 30.0, 60.0}}}}});
  std::smatch m;
  ASSERT_TRUE(std::regex_search(
      svg, m, std::regex(R"re(points="78\.0,([.0-9]+) ([.0-9]+),([.0-9]+) 934\.0,([.0-9]+) ")re")));
  const auto at = [&](std::size_t i) { return std::stod(m[i]); };
  EXPECT_NEAR(at(1) - at(4), 300.0, 0.1) << "the greatest is the last tick";
  EXPECT_NEAR(at(3), 0.5 * (at(1) + at(4)), 0.1);
  EXPECT_NEAR(at(2), 0.5 * (78.0 + 934.0), 0.1);
  EXPECT_THAT(svg, HasSubstr(">60</text>"));
}

}  // namespace
}  // namespace palpate::test
