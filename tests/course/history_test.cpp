#include "client/course/history.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Json = nlohmann::json;

TrialRow Trial(int n, std::optional<double> points, const std::string& marks = "",
               std::int64_t person = 1, const std::string& exercise = "walk") {
  return {person, exercise, n, 1'000, 1'060, "stopped", true, points, false, marks, {}, true};
}
std::vector<TrialRow> Series(const std::vector<double>& points) {
  std::vector<TrialRow> rows;
  for (const double one : points) rows.push_back(Trial(static_cast<int>(rows.size()) + 1, one));
  return rows;
}
std::string Marks(const std::vector<std::pair<std::string, double>>& marks) {
  Json json = Json::array();
  for (const auto& [name, points] : marks) {
    json.push_back({{"criterion", name}, {"value", nullptr}, {"points", points}});
  }
  return json.dump();
}
Exercise Asking(const std::vector<std::pair<std::string, double>>& weights) {
  Exercise exercise;
  exercise.name = "walk";
  exercise.title = {{"en", "A walk"}};
  exercise.trials = 2;
  for (const auto& [name, weight] : weights) {
    Criterion criterion;
    criterion.name = name;
    criterion.weight = weight;
    exercise.criteria.criteria.push_back(criterion);
  }
  return exercise;
}
Person Somebody(std::int64_t id, const std::string& name, Access role = Access::kDrive) {
  Person person;
  person.id = id;
  person.name = name;
  person.role = role;
  return person;
}
const auto kNoPages = [](const TrialRow&) { return std::string(); };

TEST(TermGrade, IsTheMeanOfTheLastTrialsWithItsInterval) {
  const TermGrade grade = GradeOf(Series({10, 70, 80, 90}), 3);
  EXPECT_EQ(grade.of, 3);
  EXPECT_DOUBLE_EQ(grade.mean, 80.0);
  EXPECT_NEAR(*grade.error, 10.0 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(*grade.low, 80.0 - 4.3027 * 10.0 / std::sqrt(3.0), 1e-9);
  EXPECT_EQ(*grade.high, 100.0) << "there is no more than 100";
}

TEST(TermGrade, SaysNothingOfWhatTooFewTrialsDoNotTell) {
  EXPECT_EQ(GradeOf({}, 5).of, 0);
  const TermGrade one = GradeOf(Series({70}), 5);
  EXPECT_EQ(one.mean, 70.0);
  EXPECT_FALSE(one.error || one.low || one.high);
  const TermGrade two = GradeOf(Series({70, 80}), 5);
  EXPECT_DOUBLE_EQ(*two.error, 5.0);
  EXPECT_FALSE(two.low || two.high);
}

TEST(TermGrade, LeavesOutWhatIsNotWholeAndWhatHasNoPoints) {
  std::vector<TrialRow> rows = Series({70, 0, 80});
  rows[1].whole = false;
  rows.push_back(Trial(4, std::nullopt));
  const TermGrade grade = GradeOf(rows, 2);
  EXPECT_EQ(grade.of, 2);
  EXPECT_EQ(grade.mean, 75.0);
}

TEST(StudentT, IsThatOfTheTables) {
  const std::vector<std::pair<int, double>> table = {{1, 12.7062}, {2, 4.3027},  {4, 2.7764},
                                                     {5, 2.5706},  {6, 2.4469},  {9, 2.2622},
                                                     {10, 2.2281}, {30, 2.0423}, {99, 1.9842}};
  for (const auto& [freedom, t] : table) EXPECT_NEAR(StudentT95(freedom), t, 1e-3) << freedom;
}

TEST(TrialSpread, HasQuartilesBetweenThePeople) {
  EXPECT_EQ(QuantileOf({7}, 0.25), 7.0);
  EXPECT_EQ(QuantileOf({4, 1, 3, 2}, 0.25), 1.75);
  EXPECT_EQ(QuantileOf({4, 1, 3, 2}, 0.5), 2.5);
  const auto spread = SpreadOf({{1, {10, 20, 30, 40, 50}}, {3, {60}}});
  ASSERT_EQ(spread.size(), 2u);
  EXPECT_EQ(spread[0].people, 5);
  EXPECT_EQ(spread[0].low, 20.0);
  EXPECT_EQ(spread[0].median, 30.0);
  EXPECT_EQ(spread[0].high, 40.0);
  EXPECT_EQ(spread[1].n, 3);
}

TEST(CriterionLoss, IsWhatACriterionCostsOfAHundredPoints) {
  const Exercise exercise = Asking({{"floor", 3}, {"force", 1}});
  const std::vector<TrialRow> rows = {Trial(1, 0, Marks({{"floor", 0}, {"force", 0}})),
                                      Trial(2, 0, Marks({{"floor", 80}, {"force", 20}})),
                                      Trial(3, 0, Marks({{"floor", 100}, {"force", 40}}))};
  const auto losses = LossesOf(rows, &exercise, 2);
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_EQ(losses[0].criterion, "force");
  EXPECT_DOUBLE_EQ(losses[0].points, 0.25 * (80 + 60) / 2);
  EXPECT_DOUBLE_EQ(losses[1].points, 0.75 * (20 + 0) / 2);
}

TEST(CriterionLoss, IsTheGatesOfWhatItTakesFromOthers) {
  Exercise exercise = Asking({{"cleared", 1}, {"pulp", 3}});
  exercise.criteria.criteria[0].gates = true;
  const std::vector<TrialRow> rows = {Trial(1, 37, R"([
    {"criterion": "cleared", "points": 40, "ungated": 40},
    {"criterion": "pulp", "points": 36, "ungated": 90}])")};
  const auto losses = LossesOf(rows, &exercise, 1);
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_EQ(losses[0].criterion, "cleared");
  EXPECT_DOUBLE_EQ(losses[0].points, (60.0 + 3 * 54.0) / 4);
  EXPECT_DOUBLE_EQ(losses[1].points, 3 * 10.0 / 4);
}

TEST(CriterionLoss, FollowsTheExerciseWhereItsCriteriaHaveChanged) {
  const std::vector<TrialRow> rows = {Trial(1, 50, Marks({{"old", 0}, {"force", 0}})),
                                      Trial(2, 50, Marks({{"force", 50}, {"new", 90}}))};
  const Exercise exercise = Asking({{"force", 1}, {"new", 1}});
  const auto losses = LossesOf(rows, &exercise, 5);
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_EQ(losses[0].criterion, "force");
  EXPECT_EQ(losses[0].of, 2);
  EXPECT_DOUBLE_EQ(losses[0].points, (100.0 + 25.0) / 2);
  EXPECT_EQ(losses[1].of, 1);
  EXPECT_DOUBLE_EQ(losses[1].points, 5.0);
  EXPECT_EQ(LossesOf(rows, nullptr, 5).size(), 3u) << "nobody knows what is asked for now";
}

TEST(CriterionLoss, CountsEachPersonOnceInAClass) {
  const auto losses = ClassLossesOf({{{"floor", 10, 5}, {"force", 20, 5}}, {{"floor", 30, 1}}});
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_EQ(losses[0].points, 20.0);
  EXPECT_EQ(losses[0].of + losses[1].of, 3);
}

TEST(TrialRow, HasNoMarksWhereTheyCannotBeRead) {
  for (const char* marks :
       {"", "null", "{", "{\"a\": 1}", "[1, {\"criterion\": 2, \"points\": 3}]",
        "[{\"criterion\": \"a\"}]", "[{\"criterion\": \"a\", \"points\": \"b\"}]"}) {
    EXPECT_THAT(MarksOf(Trial(1, 1, marks)), IsEmpty()) << marks;
  }
}

// Against other formulas: the variance over all pairs, quantiles by counting, and that points lost
// and earned add up to 100.
TEST(History, AgreesWithBruteForce) {
  Random random(31);
  const auto from = [&](int low, int high) { return low + random.Below(high - low + 1); };
  for (int round = 0; round < 200; ++round) {
    const Exercise exercise = Asking({{"a", from(1, 4)}, {"b", from(1, 4)}, {"c", from(0, 1) + 1}});
    const int last = from(1, 8);
    std::vector<TrialRow> rows;
    std::vector<double> counted;
    for (int n = 1; n <= from(1, 12); ++n) {
      std::vector<std::pair<std::string, double>> marks;
      double points = 0.0, weights = 0.0;
      for (const Criterion& criterion : exercise.criteria.criteria) {
        marks.emplace_back(criterion.name, from(0, 100));
        points += criterion.weight * marks.back().second;
        weights += criterion.weight;
      }
      rows.push_back(Trial(n, points / weights, Marks(marks)));
      rows.back().whole = from(0, 4) > 0;
      if (rows.back().whole) counted.push_back(points / weights);
    }
    if (static_cast<int>(counted.size()) > last) {
      counted.erase(counted.begin(), counted.end() - last);
    }
    const TermGrade grade = GradeOf(rows, last);
    ASSERT_EQ(grade.of, static_cast<int>(counted.size()));
    if (counted.empty()) continue;
    const double n = grade.of;
    double pairs = 0.0;
    for (const double one : counted) {
      for (const double other : counted) pairs += 0.5 * (one - other) * (one - other);
    }
    EXPECT_NEAR(grade.mean, std::accumulate(counted.begin(), counted.end(), 0.0) / n, 1e-9);
    EXPECT_NEAR(grade.error.value_or(0.0), n > 1 ? std::sqrt(pairs / n / (n - 1) / n) : 0.0, 1e-9);
    double lost = 0.0;
    for (const CriterionLoss& loss : LossesOf(rows, &exercise, last)) lost += loss.points;
    EXPECT_NEAR(lost + grade.mean, 100.0, 1e-9);
    for (const double share : {0.25, 0.5, 0.75}) {
      const double quantile = QuantileOf(counted, share);
      const auto below =
          std::ranges::count_if(counted, [&](double one) { return one < quantile - 1e-12; });
      const auto up_to =
          std::ranges::count_if(counted, [&](double one) { return one <= quantile + 1e-12; });
      EXPECT_LE(static_cast<double>(below), share * (n - 1) + 1.0);
      EXPECT_GE(static_cast<double>(up_to), share * (n - 1));
    }
  }
}

TEST(History, TellsAClassWhatAnExerciseWasThatIsGone) {
  const std::vector<TrialRow> rows = {Trial(1, std::nullopt, "", 2, "lost"),
                                      Trial(1, 60, Marks({{"floor", 60}}), 2),
                                      Trial(1, 90, Marks({{"floor", 90}}), 3), Trial(1, 10, "", 9)};
  const History history({Asking({{"floor", 1}})},
                        {Somebody(1, "teacher", Access::kOperate), Somebody(2, "Anna"),
                         Somebody(3, "Ben"), Somebody(4, "Cleo")},
                        rows);
  const Json of_class = Json::parse(history.ClassJson());
  ASSERT_EQ(of_class["exercises"].size(), 2u);
  EXPECT_EQ(of_class["exercises"][0]["name"], "lost");
  EXPECT_TRUE(of_class["exercises"][0]["pass"].is_null());
  EXPECT_EQ(of_class["exercises"][1]["spread"][0]["median"], 75.0)
      << "nobody's trial counts nowhere";
  EXPECT_EQ(of_class["exercises"][1]["lost"][0]["points"], 25.0);
  ASSERT_EQ(of_class["people"].size(), 3u) << "who teaches and tried nothing is not of the class";
  EXPECT_EQ(of_class["people"][0]["did"][1]["grade"]["mean"], 60.0);
  EXPECT_THAT(of_class["people"][2]["did"], IsEmpty());
}

TEST(History, TellsTheNamesOfCriteriaInEachLanguage) {
  Exercise exercise = Asking({{"floor", 1}});
  exercise.criteria.criteria[0].names = {{"en", "floor"}, {"de", "Boden"}};
  std::vector<TrialRow> rows{Trial(1, 50)};
  rows[0].person = 2;
  rows[0].marks = Marks({{"floor", 50}});
  const History history({exercise}, {Somebody(2, "Anna")}, rows);
  for (const std::string& json : {history.ClassJson(), history.PersonJson(2, true, kNoPages)}) {
    const Json of = Json::parse(json)["exercises"][0];
    EXPECT_EQ(of["lost"][0]["criterion"], "floor");
    EXPECT_EQ(of["criteria"]["floor"]["de"], "Boden");
  }
}

TEST(History, ShowsAPersonTheClassOnlyWhereItIsNoSinglePerson) {
  std::vector<TrialRow> rows;
  std::vector<Person> people;
  for (int person = 1; person <= History::kLeastForOthers; ++person) {
    people.push_back(Somebody(person, "p"));
    rows.push_back(Trial(1, 10 * person, "", person));
    if (person > 1) rows.push_back(Trial(2, 50, "", person));
  }
  const History history({Asking({})}, people, rows);
  const Json own = Json::parse(history.PersonJson(2, false, kNoPages));
  EXPECT_EQ(own["exercises"][0]["spread"].size(), 1u);
  EXPECT_EQ(own["exercises"][0]["done"].size(), 2u);
  const Json seen = Json::parse(history.PersonJson(2, true, kNoPages));
  EXPECT_EQ(seen["exercises"][0]["spread"].size(), 2u);
  EXPECT_THAT(Json::parse(history.PersonJson(77, true, kNoPages))["exercises"], IsEmpty());
}

TEST(History, IsReadFromTheCourseWithItsGaps) {
  const Folder folder;
  CourseFile file(folder / "course");
  const TrialTable table(file);
  EXPECT_THAT(table.Ended(), IsEmpty());
  file.Use([](SQLite::Database& database) {
    database.exec(
        "INSERT INTO trials VALUES(2, 'walk', 2, 5, 6, NULL, NULL, NULL, NULL, NULL, NULL, NULL);"
        "INSERT INTO trials VALUES(2, 'walk', 1, 5, 6, 'stopped', 1, 70.5, 1, '[]', 9, NULL);"
        "INSERT INTO trials VALUES(2, 'walk', 3, 5, NULL, NULL, NULL, NULL, NULL, NULL, NULL, "
        "NULL);"
        "INSERT INTO trials VALUES(1, 'walk', 1, 5, 6, 'stopped', 1, 60, 0, '[]', NULL, NULL);");
  });
  const auto rows = table.Ended();
  ASSERT_EQ(rows.size(), 3u) << "one runs";
  EXPECT_EQ(rows[1].points, 70.5);
  EXPECT_EQ(rows[1].submitted_s, 9);
  EXPECT_FALSE(rows[2].counts());
  EXPECT_EQ(table.Ended(1).size(), 1u);
}

TEST(Csv, IsThatOfRfc4180AndRunsInNoSpreadsheet) {
  EXPECT_EQ(CsvField("plain"), "plain");
  EXPECT_EQ(CsvField("a, \"b\""), "\"a, \"\"b\"\"\"");
  EXPECT_EQ(CsvField("a; b"), "\"a; b\"");
  EXPECT_EQ(CsvField("two\nlines"), "\"two\nlines\"");
  for (const char* text : {"=1+1", "+1", "-1", "@x", "\tx", "\rx"}) {
    EXPECT_EQ(CsvField(text), "\"'" + std::string(text) + "\"");
  }
  std::vector<TrialRow> rows = {Trial(1, 60, Marks({{"floor", 60}}), 2),
                                Trial(2, std::nullopt, "", 2)};
  rows[0].submitted_s = 86'400;
  const History history({}, {Somebody(2, "=cmd|' /C calc'!A0")}, rows);
  EXPECT_EQ(
      history.Csv(),
      "\xEF\xBB\xBFperson,name,exercise,trial,begun,ended,whole,reason,points,passed,submitted,"
      "walk: floor\r\n"
      "2,\"'=cmd|' /C calc'!A0\",walk,1,1970-01-01T00:16:40Z,1970-01-01T00:17:40Z,yes,stopped,"
      "60.00,no,1970-01-02T00:00:00Z,60.00\r\n"
      "2,\"'=cmd|' /C calc'!A0\",walk,2,1970-01-01T00:16:40Z,1970-01-01T00:17:40Z,yes,stopped,"
      ",no,,\r\n");
  EXPECT_EQ(history.Csv(2), history.Csv());
  EXPECT_THAT(history.Csv(2, CsvAs::kDecimalComma),
              HasSubstr(";yes;stopped;60,00;no;1970-01-02T00:00:00Z;60,00\r\n"));
  EXPECT_THAT(history.Csv(2, CsvAs::kSemicolon),
              HasSubstr(";yes;stopped;60.00;no;1970-01-02T00:00:00Z;60.00\r\n"));
}

}  // namespace
}  // namespace palpate::test
