#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "client/course/exam_table.h"

namespace palpate {

/// Whose turn it is in an exam whose scenes have fewer seats than candidates: each candidate's
/// order of tasks, and the queue of those who wait for a seat.  Order and queue are kept in the
/// course's file, so that the next gateway has the same ones. Thread contract: one thread.  Seconds
/// count from 1970.
class ExamTurns {
 public:
  /// How long a free seat is kept for the first in the queue, who is to begin meanwhile.
  static constexpr std::int64_t kCalled_s = 60;
  /// How long a candidate without a page keeps the place in the queue.
  static constexpr std::int64_t kAway_s = 30;

  /// What the gateway knows of seats and pages.
  struct Seats {
    /// Returns the seats of a scene in which that person may begin now; the preferred one first.
    std::function<std::vector<std::string>(std::int64_t person, const std::string& scene)> free;
    /// Returns whether a page of that person is there.
    std::function<bool(std::int64_t person)> is_here;
  };
  struct Turn {
    std::vector<int> tasks;     ///< indices of the exam's tasks, in this candidate's order
    std::int64_t place = 0;     ///< in the queue, from 1; 0: asks for no seat
    std::int64_t asked_s = 0;   ///< since when this candidate waits
    std::int64_t waited_s = 0;  ///< and waited before, since the last trial began
    std::string seat;           ///< kept for this candidate; empty: none is free yet
    std::int64_t until_s = 0;   ///< until when
    std::int64_t seen_s = 0;    ///< when a page of theirs was last there; 0: not looked yet

    bool waits() const { return place != 0 && seat.empty(); }
    std::int64_t WaitsFor_s(std::int64_t now_s) const {
      return waits() ? std::max<std::int64_t>(0, now_s - asked_s) : 0;
    }
  };

  /// Returns the order of tasks of the n-th candidate, from 0.  If the exam rotates, the tasks of
  /// one scene follow each other, and each candidate begins at another scene than the one before.
  /// @param scenes  of each task.
  static std::vector<int> OrderOf(std::size_t n, bool rotates,
                                  const std::vector<std::string>& scenes);

  explicit ExamTurns(ExamTable& table) : table_(table) {}

  /// Reads the turns of an exam, unless they are those that it has.
  /// @param tasks  the number of tasks, for an exam that was opened without orders.
  void Read(std::int64_t exam, const std::set<std::int64_t>& people, int tasks);
  const Turn& Of(std::int64_t person) const;
  /// Returns how many wait for a seat of the same scene before that person.
  /// @param scene_of  the scene of a person's present task.
  int AheadOf(std::int64_t person,
              const std::function<std::string(std::int64_t person)>& scene_of) const;
  bool IsKept(const std::string& seat) const;

  /// Puts a candidate at the queue's end, unless they are in it.  Throws Error.
  void Ask(std::int64_t person, std::int64_t now_s);
  /// Gives free seats to those who have waited longest for their scene, and takes turns back from
  /// those who do not begin or are away.  Returns whether anything has changed.  Throws Error.
  bool Call(std::int64_t now_s, const Seats& seats,
            const std::function<std::string(std::int64_t person)>& scene_of);
  /// A candidate's trial begins: first in the file, so that the caller may undo it, and then here.
  void Begin(std::int64_t person) { table_.Keep(exam_, {person, Of(person).tasks}); }
  void Begun(std::int64_t person) { turns_[person] = Turn{Of(person).tasks, 0, 0, 0, "", 0, 0}; }
  /// Moves all times, with the computer's clock or because they do not count.  Throws Error.
  void Move(std::int64_t by_s);

 private:
  void Keep(std::int64_t person, const Turn& turn);
  /// Returns those who wait, in their order.
  std::vector<std::int64_t> Queue() const;

  ExamTable& table_;
  std::int64_t exam_ = 0;
  std::map<std::int64_t, Turn> turns_;  // by person
  std::int64_t last_place_ = 0;
};

}  // namespace palpate
