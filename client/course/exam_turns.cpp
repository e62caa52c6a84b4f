#include "client/course/exam_turns.h"

#include <algorithm>
#include <ranges>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kTable = R"(CREATE TABLE IF NOT EXISTS exam_turns(
  exam INTEGER NOT NULL, person INTEGER NOT NULL, tasks TEXT NOT NULL,
  place INTEGER NOT NULL DEFAULT 0, asked_s INTEGER NOT NULL DEFAULT 0,
  waited_s INTEGER NOT NULL DEFAULT 0, PRIMARY KEY(exam, person)))";

}  // namespace

std::vector<int> ExamTurns::OrderOf(std::size_t n, bool rotates,
                                    const std::vector<std::string>& scenes) {
  std::vector<int> order(scenes.size());
  std::ranges::copy(std::views::iota(0, static_cast<int>(scenes.size())), order.begin());
  if (!rotates || scenes.empty()) return order;
  std::vector<std::string> groups;  // in the order of their first tasks
  for (const std::string& scene : scenes) {
    if (std::ranges::find(groups, scene) == groups.end()) groups.push_back(scene);
  }
  std::ranges::rotate(groups, groups.begin() + static_cast<std::ptrdiff_t>(n % groups.size()));
  std::ranges::stable_sort(order, {}, [&](int task) {
    return std::ranges::find(groups, scenes[static_cast<std::size_t>(task)]);
  });
  return order;
}

ExamTurns::ExamTurns(CourseFile& file) : file_(file) {
  file_.Use([](SQLite::Database& database) { database.exec(kTable); });
}

void ExamTurns::Store(SQLite::Database& database, std::int64_t exam, std::int64_t person,
                      const std::vector<int>& tasks) {
  SQLite::Statement row(database, "INSERT INTO exam_turns(exam, person, tasks) VALUES(?, ?, ?)");
  row.bind(1, exam);
  row.bind(2, person);
  row.bind(3, Json(tasks).dump());
  row.exec();
}

void ExamTurns::Read(std::int64_t exam, const std::set<std::int64_t>& people, int tasks) {
  if (exam == exam_) return;
  std::map<std::int64_t, Turn> turns;
  std::int64_t last_place = 0;
  for (const std::int64_t person : people) {
    turns[person].tasks =
        OrderOf(0, false, std::vector<std::string>(static_cast<std::size_t>(tasks)));
  }
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement rows(
        database, "SELECT person, tasks, place, asked_s, waited_s FROM exam_turns WHERE exam=?");
    rows.bind(1, exam);
    while (rows.executeStep()) {
      const auto found = turns.find(rows.getColumn(0).getInt64());
      if (found == turns.end()) continue;
      Turn& turn = found->second;
      // The course's file may have been changed by hand: an order is one of all tasks, or none.
      const std::vector<int> order =
          Json::parse(rows.getColumn(1).getString()).get<std::vector<int>>();
      if (std::ranges::is_permutation(order, turn.tasks)) turn.tasks = order;
      turn.place = rows.getColumn(2).getInt64();
      turn.asked_s = rows.getColumn(3).getInt64();
      turn.waited_s = rows.getColumn(4).getInt64();
      last_place = std::max(last_place, turn.place);
    }
  });
  exam_ = exam;
  turns_ = std::move(turns);
  last_place_ = last_place;
}

const ExamTurns::Turn& ExamTurns::Of(std::int64_t person) const {
  static const Turn none;
  const auto found = turns_.find(person);
  return found == turns_.end() ? none : found->second;
}

std::vector<std::int64_t> ExamTurns::Queue() const {
  std::vector<std::int64_t> queue;
  for (const auto& [person, turn] : turns_) {
    if (turn.waits()) queue.push_back(person);
  }
  std::ranges::sort(queue, {}, [&](std::int64_t person) { return Of(person).place; });
  return queue;
}

int ExamTurns::AheadOf(std::int64_t person,
                       const std::function<std::string(std::int64_t person)>& scene_of) const {
  int ahead = 0;
  for (const std::int64_t other : Queue()) {
    if (other == person) break;
    if (scene_of(other) == scene_of(person)) ++ahead;
  }
  return ahead;
}

bool ExamTurns::IsKept(const std::string& seat) const {
  return !seat.empty() &&
         std::ranges::any_of(turns_, [&](const auto& entry) { return entry.second.seat == seat; });
}

void ExamTurns::Keep(std::int64_t person, const Turn& turn) {
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement row(
        database,
        "INSERT INTO exam_turns(exam, person, tasks, place, asked_s, waited_s) VALUES(?, ?, ?, ?, "
        "?, ?) ON CONFLICT(exam, person) DO UPDATE SET place=excluded.place, "
        "asked_s=excluded.asked_s, waited_s=excluded.waited_s");
    row.bind(1, exam_);
    row.bind(2, person);
    row.bind(3, Json(turn.tasks).dump());
    row.bind(4, turn.place);
    row.bind(5, turn.asked_s);
    row.bind(6, turn.waited_s);
    row.exec();
  });
  turns_[person] = turn;
}

void ExamTurns::Ask(std::int64_t person, std::int64_t now_s) {
  Turn turn = Of(person);
  if (turn.place != 0) return;
  turn.place = last_place_ + 1;
  turn.asked_s = turn.seen_s = now_s;
  Keep(person, turn);
  last_place_ = turn.place;
}

bool ExamTurns::Call(std::int64_t now_s, const Seats& seats,
                     const std::function<std::string(std::int64_t person)>& scene_of) {
  bool changed = false;
  std::set<std::string> kept;
  for (auto& [person, old] : turns_) {
    if (old.place == 0) continue;
    if (old.seen_s == 0 || seats.is_here(person)) old.seen_s = now_s;
    Turn turn = old;
    const bool is_late = !turn.seat.empty() && now_s >= turn.until_s;
    if (is_late || now_s - turn.seen_s > kAway_s) {
      turn.waited_s += turn.WaitsFor_s(now_s);
      turn.place = 0;
      turn.seat.clear();
    } else if (!turn.seat.empty() &&
               std::ranges::count(seats.free(person, scene_of(person)), turn.seat) == 0) {
      turn.asked_s = now_s;  // somebody has taken it: the first in the queue is still the first
      turn.seat.clear();
    } else {
      kept.insert(turn.seat);
      continue;
    }
    Keep(person, turn);
    changed = true;
  }
  for (const std::int64_t person : Queue()) {
    if (!seats.is_here(person)) continue;
    Turn turn = Of(person);
    for (const std::string& seat : seats.free(person, scene_of(person))) {
      if (!kept.insert(seat).second) continue;
      turn.waited_s += turn.WaitsFor_s(now_s);
      turn.asked_s = now_s;
      turn.seat = seat;
      turn.until_s = now_s + kCalled_s;
      Keep(person, turn);
      changed = true;
      break;
    }
  }
  return changed;
}

void ExamTurns::Begin(SQLite::Database& database, std::int64_t person) const {
  SQLite::Statement row(
      database, "UPDATE exam_turns SET place=0, asked_s=0, waited_s=0 WHERE exam=? AND person=?");
  row.bind(1, exam_);
  row.bind(2, person);
  row.exec();
}

void ExamTurns::Begun(std::int64_t person) {
  Turn begun;
  begun.tasks = Of(person).tasks;
  turns_[person] = begun;
}

void ExamTurns::Move(std::int64_t by_s) {
  for (auto& [person, old] : turns_) {
    if (old.place == 0) continue;
    Turn turn = old;
    turn.asked_s += by_s;
    turn.until_s += by_s;
    if (turn.seen_s != 0) turn.seen_s += by_s;
    Keep(person, turn);
  }
}

}  // namespace palpate
