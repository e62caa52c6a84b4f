#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/roster.h"
#include "client/course/trial.h"
#include "client/viewer/tokens.h"

namespace palpate {

/// A command of a teacher's page, on the channel /palpate/class.  Only these fields are accepted:
///   {"tag": 1, "op": "person_make", "names": [NAME, ...], "role": "watch" | "drive" | "operate"}
///   {"tag": 2, "op": "person_rename", "person": ID, "name": NAME}
///   {"tag": 3, "op": "person_withdraw", "person": ID}
///   {"tag": 4, "op": "person_link", "person": ID}               makes a new token
///   {"tag": 5, "op": "person_delete", "person": ID}             with all of their data
///   {"tag": 6, "op": "say", "person": ID, "text": TEXT}         0: to all
///   {"tag": 7, "op": "begin", "scene": NAME}                    assigns seats; "": takes them back
struct ClassCommand {
  enum class Op { kMake, kRename, kWithdraw, kLink, kDelete, kSay, kBegin };
  static constexpr std::size_t kMostNames = 200;
  static constexpr std::size_t kLongestText = 480;  ///< bytes
  std::uint32_t tag = 0;                            ///< repeated in the answer
  Op op = Op::kSay;
  std::int64_t person = 0;
  std::vector<std::string> names;
  Access role = Access::kDrive;
  std::string text;
  std::string scene;
};
/// Returns "person_make" and so on.
std::string_view ClassOpName(ClassCommand::Op op);
inline bool ChangesTokens(ClassCommand::Op op) {
  return op < ClassCommand::Op::kSay;
}
/// Throws Error if it is no such command.
ClassCommand ParseClassCommand(std::string_view json);

/// Returns the seats of a scene that are served, in order: NAME-1, NAME-2, ...
std::vector<std::string> SeatsOf(const std::string& scene, const std::set<std::string>& scenes);

/// The people of a course within the gateway: their tokens, seats, and the lines that a
/// teacher sends them.  Seats and lines last for one run of the gateway; people are stored in
/// the course's file.
/// Thread contract: the network thread.
class ClassRoom {
 public:
  using Scenes = std::set<std::string>;
  /// Returns how many pages a person has open.
  using Here = std::function<int(std::int64_t person)>;
  /// Returns whether a trial of the person is being recorded or scored.
  using Busy = std::function<bool(std::int64_t person)>;

  /// Throws Error, as CourseFile does.
  explicit ClassRoom(const std::string& folder);

  CourseFile& file() { return file_; }
  Roster& roster() { return roster_; }
  /// Makes a token for a teacher if nobody has the role "operate" yet.
  std::optional<Roster::Made> MakeFirstTeacher();
  /// Returns `others`, the tokens of --tokens, together with the course's.  Throws Error if two
  /// give the same station name.
  Tokens With(Tokens others) const;

  /// Carries out a command and returns the answer for the page: {tag, refusal, note, people}.
  /// @param others  the tokens of --tokens, whose names are taken.
  std::string Do(const ClassCommand& command, const Tokens& others, const Scenes& scenes,
                 const Here& here, const Busy& busy);
  /// Assigns a free seat to a person who has connected, if the class has begun.
  void Enter(std::int64_t person, const Scenes& scenes);
  /// Returns the person's seat; empty: they may drive anywhere.
  std::string SeatOf(std::int64_t person) const;
  /// Returns the person whose seat it is; 0: nobody's.
  std::int64_t OwnerOf(const std::string& seat) const;
  /// Returns why a person may do nothing in a scene; empty: they may.
  /// @param person  not a teacher.
  std::string WhyNotAt(std::int64_t person, const std::string& scene) const;

  /// Returns all people, for teachers.
  /// @param trials  newest trials of this run of the gateway, by person.
  /// @param exercises  whose titles these have.
  /// @param prefix  of stations that are named after tokens.
  std::string PeopleJson(const Here& here, const std::map<std::int64_t, TrialRoom::News>& trials,
                         const std::vector<Exercise>& exercises, const std::string& prefix) const;
  /// Returns what a person is told: {person, name, role, seat, line, lines, names}; `lines` counts
  /// the lines so far.
  /// @param names  of those who hold tools, by station.
  std::string OwnJson(std::int64_t person, const std::map<std::string, std::string>& names) const;

 private:
  struct Announced {
    std::string seat;
    std::string line;
    std::uint64_t lines = 0;
  };
  void Say(std::int64_t person, const std::string& text);
  void Delete(std::int64_t person, const Busy& busy);
  /// Assigns seats.  Returns a note for the teacher.
  std::string Begin(const std::string& scene, const Scenes& scenes, const Here& here);

  const std::string folder_;
  CourseFile file_;
  Roster roster_;
  std::string scene_;  // whose seats are assigned; empty: none are
  std::map<std::int64_t, Announced> announced_;
};

}  // namespace palpate
