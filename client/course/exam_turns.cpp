#include "client/course/exam_turns.h"

#include <algorithm>
#include <ranges>
#include <utility>

namespace palpate {

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

void ExamTurns::Read(std::int64_t exam, const std::set<std::int64_t>& people, int tasks) {
  if (exam == exam_) return;
  std::map<std::int64_t, Turn> turns;
  std::int64_t last_place = 0;
  for (const std::int64_t person : people) {
    turns[person].tasks =
        OrderOf(0, false, std::vector<std::string>(static_cast<std::size_t>(tasks)));
  }
  for (const TurnRow& row : table_.TurnsOf(exam)) {
    const auto found = turns.find(row.person);
    if (found == turns.end()) continue;
    Turn& turn = found->second;
    // The course's file may have been changed by hand: an order is one of all tasks, or none.
    if (std::ranges::is_permutation(row.tasks, turn.tasks)) turn.tasks = row.tasks;
    turn.place = row.place;
    turn.asked_s = row.asked_s;
    turn.waited_s = row.waited_s;
    last_place = std::max(last_place, turn.place);
  }
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
  table_.Keep(exam_, {person, turn.tasks, turn.place, turn.asked_s, turn.waited_s});
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
