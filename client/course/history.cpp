#include "client/course/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::json;

/// How many trials make a grade if the exercise no longer exists.
constexpr int kLastWithoutExercise = 5;

Json JsonOf(const TermGrade& grade) {
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  return {{"of", grade.of},
          {"mean", grade.of > 0 ? Json(grade.mean) : Json(nullptr)},
          {"error", number(grade.error)},
          {"low", number(grade.low)},
          {"high", number(grade.high)}};
}

Json JsonOf(const std::vector<TrialSpread>& spread, int least) {
  Json json = Json::array();
  for (const TrialSpread& at : spread) {
    if (at.people < least) continue;
    json.push_back({{"n", at.n},
                    {"people", at.people},
                    {"low", at.low},
                    {"median", at.median},
                    {"high", at.high}});
  }
  return json;
}

Json JsonOf(const std::vector<CriterionLoss>& losses) {
  Json json = Json::array();
  for (const CriterionLoss& loss : losses) {
    json.push_back({{"criterion", loss.criterion}, {"points", loss.points}, {"of", loss.of}});
  }
  return json;
}

Json JsonOf(const std::string& name, const Exercise* exercise, int last) {
  Json title = Json::object(), criteria = Json::object();
  if (exercise != nullptr) {
    title = exercise->title;
    for (const Criterion& one : exercise->criteria.criteria) criteria[one.name] = one.names;
  }
  return {{"name", name},
          {"title", title},
          {"criteria", criteria},
          {"trials", last},
          {"pass", exercise != nullptr ? Json(exercise->criteria.pass) : Json(nullptr)}};
}

std::string TextOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The trials that make the grade.
std::vector<const TrialRow*> LastThatCount(TrialRows rows, int last) {
  std::vector<const TrialRow*> counted;
  for (const TrialRow& row : rows) {
    if (row.counts()) counted.push_back(&row);
  }
  const auto most = static_cast<std::size_t>(std::max(last, 1));
  if (counted.size() > most) counted.erase(counted.begin(), counted.end() - std::ptrdiff_t(most));
  return counted;
}

/// Returns what a criterion now is in the exercise; of weight 0 if the exercise no longer has it.
Criterion NowIn(const Exercise* exercise, const std::string& criterion) {
  Criterion now;
  if (exercise == nullptr) return now;
  now.weight = 0.0;
  const auto& all = exercise->criteria.criteria;
  const auto found = std::ranges::find(all, criterion, &Criterion::name);
  return found == all.end() ? now : *found;
}

std::vector<CriterionLoss> MostFirst(const std::map<std::string, std::pair<double, int>>& sums) {
  std::vector<CriterionLoss> losses;
  for (const auto& [criterion, sum] : sums) {
    losses.push_back({criterion, sum.first / sum.second, sum.second});
  }
  std::ranges::stable_sort(losses, std::greater(), &CriterionLoss::points);
  return losses;
}

/// Formats a time in UTC so that spreadsheets recognise it.
std::string WhenOf(std::int64_t time_s) {
  const std::time_t time = time_s;
  std::tm utc{};
  std::array<char, 32> text{};
  if (gmtime_r(&time, &utc) == nullptr) return "";
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

const char* YesOf(bool is) {
  return is ? "yes" : "no";
}

}  // namespace

std::vector<TrialMark> MarksOf(const TrialRow& row) {
  std::vector<TrialMark> marks;
  const Json json = Json::parse(row.marks, nullptr, false);
  if (!json.is_array()) return marks;
  for (const Json& mark : json) {
    if (!mark.is_object()) continue;
    const auto name = mark.find("criterion");
    const auto points = mark.find("points");
    if (name == mark.end() || !name->is_string() || points == mark.end() || !points->is_number()) {
      continue;
    }
    const auto ungated = mark.find("ungated");
    marks.push_back({*name, *points,
                     ungated != mark.end() && ungated->is_number() ? ungated->get<double>()
                                                                   : points->get<double>()});
  }
  return marks;
}

double StudentT95(int freedom) {
  // Tabulated where the expansion's error exceeds 0.001.
  constexpr std::array kFew = {12.7062, 4.3027, 3.1824, 2.7764};
  if (freedom <= static_cast<int>(kFew.size())) {
    return kFew.at(static_cast<std::size_t>(std::max(freedom, 1) - 1));
  }
  // Abramowitz & Stegun, Handbook of Mathematical Functions, 26.7.5, for the 97.5th percentile.
  constexpr std::array kTerms = {1.959963985, 2.372271, 2.822499, 2.555850, 1.589534};
  double t = 0.0;
  for (auto term = kTerms.rbegin(); term != kTerms.rend(); ++term) t = t / freedom + *term;
  return t;
}

TermGrade GradeOf(TrialRows rows, int last) {
  const std::vector<const TrialRow*> counted = LastThatCount(rows, last);
  TermGrade grade;
  grade.of = static_cast<int>(counted.size());
  if (counted.empty()) return grade;
  double sum = 0.0, squares = 0.0;
  for (const TrialRow* row : counted) sum += *row->points;
  const double n = grade.of;
  grade.mean = sum / n;
  if (grade.of < 2) return grade;
  for (const TrialRow* row : counted) squares += std::pow(*row->points - grade.mean, 2);
  grade.error = std::sqrt(squares / (n - 1.0) / n);
  if (grade.of < TermGrade::kLeastForInterval) return grade;
  const double half = StudentT95(grade.of - 1) * *grade.error;
  grade.low = std::max(0.0, grade.mean - half);
  grade.high = std::min(100.0, grade.mean + half);
  return grade;
}

double QuantileOf(std::vector<double> values, double share) {
  std::ranges::sort(values);
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

std::vector<TrialSpread> SpreadOf(const PointsByTrial& points) {
  std::vector<TrialSpread> spread;
  for (const auto& [n, values] : points) {
    spread.push_back({n, static_cast<int>(values.size()), QuantileOf(values, 0.25),
                      QuantileOf(values, 0.5), QuantileOf(values, 0.75)});
  }
  return spread;
}

std::vector<CriterionLoss> LossesOf(TrialRows rows, const Exercise* exercise, int last) {
  std::map<std::string, std::pair<double, int>> sums;
  for (const TrialRow* row : LastThatCount(rows, last)) {
    const auto marks = MarksOf(*row);
    double weights = 0.0, taken = 0.0, undone = 0.0;
    for (const TrialMark& mark : marks) {
      const Criterion now = NowIn(exercise, mark.criterion);
      weights += now.weight;
      taken += now.weight * (mark.ungated - mark.points);
      if (now.gates) undone += 100.0 - mark.points;
    }
    for (const TrialMark& mark : marks) {
      const Criterion now = NowIn(exercise, mark.criterion);
      if (now.weight <= 0.0) continue;
      auto& [lost, of] = sums[mark.criterion];
      lost += now.weight / weights * (100.0 - (undone > 0.0 ? mark.ungated : mark.points));
      if (now.gates && undone > 0.0) lost += taken / weights * (100.0 - mark.points) / undone;
      ++of;
    }
  }
  return MostFirst(sums);
}

std::vector<CriterionLoss> ClassLossesOf(const std::vector<std::vector<CriterionLoss>>& losses) {
  std::map<std::string, std::pair<double, int>> sums;
  for (const auto& of_one : losses) {
    for (const CriterionLoss& loss : of_one) {
      auto& [lost, of] = sums[loss.criterion];
      lost += loss.points;
      ++of;
    }
  }
  return MostFirst(sums);
}

History::History(std::vector<Exercise> exercises, std::vector<Person> people,
                 std::vector<TrialRow> rows)
    : exercises_(std::move(exercises)), people_(std::move(people)), rows_(std::move(rows)) {}

const Exercise* History::Find(const std::string& exercise) const {
  const auto found = std::ranges::find(exercises_, exercise, &Exercise::name);
  return found == exercises_.end() ? nullptr : &*found;
}

int History::LastOf(const std::string& exercise) const {
  const Exercise* const found = Find(exercise);
  return found != nullptr ? found->trials : kLastWithoutExercise;
}

const Person* History::PersonOf(std::int64_t person) const {
  const auto found = std::ranges::lower_bound(people_, person, {}, &Person::id);
  return found == people_.end() || found->id != person ? nullptr : &*found;
}

TrialRows History::RowsOf(std::int64_t person) const {
  const auto begin = std::ranges::lower_bound(rows_, person, {}, &TrialRow::person);
  return {begin, std::ranges::upper_bound(begin, rows_.end(), person, {}, &TrialRow::person)};
}

std::map<std::string, PointsByTrial> History::ClassPoints() const {
  std::map<std::string, PointsByTrial> points;
  ForEachSeries(rows_, [&](TrialRows series) {
    const Person* const person = PersonOf(series.front().person);
    if (person == nullptr || person->role == Access::kOperate) return;
    PointsByTrial& of_exercise = points[series.front().exercise];
    for (const TrialRow& row : series) {
      if (row.counts()) of_exercise[row.n].push_back(*row.points);
    }
  });
  return points;
}

std::string History::ClassJson() const {
  std::map<std::string, std::vector<std::vector<CriterionLoss>>> lost;
  Json people = Json::array();
  for (const Person& person : people_) {
    Json did = Json::array();
    ForEachSeries(RowsOf(person.id), [&](TrialRows series) {
      const std::string& name = series.front().exercise;
      auto losses = LossesOf(series, Find(name), LastOf(name));
      Json points = Json::array();
      for (const TrialRow& row : series) {
        // To the precision that a curve shows.
        if (row.counts()) points.push_back({row.n, std::round(10.0 * *row.points) / 10.0});
      }
      did.push_back({{"exercise", name},
                     {"done", series.size()},
                     {"points", points},
                     {"grade", JsonOf(GradeOf(series, LastOf(name)))},
                     {"lost", JsonOf({losses.begin(), losses.begin() + !losses.empty()})}});
      if (person.role != Access::kOperate) lost[name].push_back(std::move(losses));
    });
    // A teacher is listed only with trials of their own.
    if (person.role == Access::kOperate && did.empty() && person.here()) continue;
    people.push_back({{"person", person.id},
                      {"name", person.name},
                      {"role", RoleName(person.role)},
                      {"here", person.here()},
                      {"did", did}});
  }
  Json exercises = Json::array();
  for (const auto& [name, points] : ClassPoints()) {
    Json exercise = JsonOf(name, Find(name), LastOf(name));
    exercise["spread"] = JsonOf(SpreadOf(points), 1);
    exercise["lost"] = JsonOf(ClassLossesOf(lost[name]));
    exercises.push_back(exercise);
  }
  return TextOf({{"exercises", exercises}, {"people", people}});
}

std::string History::PersonJson(std::int64_t id, bool for_teacher, const PageOf& page) const {
  const auto class_points = ClassPoints();
  Json exercises = Json::array();
  ForEachSeries(RowsOf(id), [&](TrialRows series) {
    const std::string& name = series.front().exercise;
    Json done = Json::array();
    for (const TrialRow& row : series) {
      Json marks = Json::array();
      for (const TrialMark& mark : MarksOf(row)) {
        marks.push_back({{"criterion", mark.criterion}, {"points", mark.points}});
      }
      done.push_back({{"n", row.n},
                      {"begun_s", row.begun_s},
                      {"points", row.points ? Json(*row.points) : Json(nullptr)},
                      {"passed", row.passed},
                      {"whole", row.whole},
                      {"submitted", row.submitted_s.has_value()},
                      {"reason", row.reason},
                      {"page", page(row)},
                      {"marks", marks}});
    }
    const auto of_class = class_points.find(name);
    Json exercise = JsonOf(name, Find(name), LastOf(name));
    exercise["done"] = done;
    exercise["grade"] = JsonOf(GradeOf(series, LastOf(name)));
    exercise["lost"] = JsonOf(LossesOf(series, Find(name), LastOf(name)));
    exercise["spread"] = JsonOf(
        of_class == class_points.end() ? std::vector<TrialSpread>{} : SpreadOf(of_class->second),
        for_teacher ? 1 : kLeastForOthers);
    exercises.push_back(exercise);
  });
  const Person* const person = PersonOf(id);
  return TextOf({{"person", id},
                 {"name", person != nullptr ? person->name : ""},
                 {"here", person != nullptr && person->here()},
                 {"exercises", exercises}});
}

std::string History::Csv(std::int64_t id, CsvAs as) const {
  const TrialRows rows = id == 0 ? TrialRows(rows_) : RowsOf(id);
  std::set<std::pair<std::string, std::string>> columns;  // exercise, criterion
  std::vector<std::vector<TrialMark>> marks;
  for (const TrialRow& row : rows) {
    marks.push_back(MarksOf(row));
    for (const TrialMark& mark : marks.back()) columns.emplace(row.exercise, mark.criterion);
  }
  const auto number = [as](double value) {
    std::string text = fmt::format("{:.2f}", value);
    if (as == CsvAs::kDecimalComma) std::ranges::replace(text, '.', ',');
    return text;
  };
  const auto line = [as](const std::vector<std::string>& fields) {
    return fmt::format("{}\r\n", fmt::join(fields, as == CsvAs::kRfc4180 ? "," : ";"));
  };
  std::vector<std::string> head{"person", "name",   "exercise", "trial",  "begun",    "ended",
                                "whole",  "reason", "points",   "passed", "submitted"};
  for (const auto& [exercise, criterion] : columns) {
    head.push_back(CsvField(exercise + ": " + criterion));
  }
  // The byte-order mark tells spreadsheets that it is UTF-8.
  std::string csv = "\xEF\xBB\xBF" + line(head);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TrialRow& row = rows[i];
    const Person* const person = PersonOf(row.person);
    std::vector<std::string> fields{std::to_string(row.person),
                                    CsvField(person != nullptr ? person->name : ""),
                                    CsvField(row.exercise),
                                    std::to_string(row.n),
                                    WhenOf(row.begun_s),
                                    WhenOf(row.ended_s),
                                    YesOf(row.whole),
                                    CsvField(row.reason),
                                    row.points ? number(*row.points) : "",
                                    YesOf(row.passed),
                                    row.submitted_s ? WhenOf(*row.submitted_s) : ""};
    for (const auto& [exercise, criterion] : columns) {
      const auto mark = exercise == row.exercise
                            ? std::ranges::find(marks[i], criterion, &TrialMark::criterion)
                            : marks[i].end();
      fields.push_back(mark == marks[i].end() ? "" : number(mark->points));
    }
    csv += line(fields);
  }
  return csv;
}

std::string CsvField(const std::string& text) {
  const bool would_run = text.find_first_of("=+-@\t\r") == 0;
  if (!would_run && text.find_first_of(",;\"\r\n") == text.npos) return text;
  std::string field = would_run ? "\"'" : "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + "\"";
}

}  // namespace palpate
