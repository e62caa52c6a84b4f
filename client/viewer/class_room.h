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
#include "client/viewer/tokens.h"

namespace palpate {

/// Of a teacher's page, on the channel /palpate/class, these fields and no others:
///   {"tag": 1, "op": "person_make", "names": [NAME, ...], "role": "watch" | "drive" | "operate"}
///   {"tag": 2, "op": "person_rename", "person": ID, "name": NAME}
///   {"tag": 3, "op": "person_withdraw", "person": ID}
///   {"tag": 4, "op": "person_link", "person": ID}               another token
///   {"tag": 5, "op": "person_delete", "person": ID}             with all that they did
///   {"tag": 6, "op": "say", "person": ID, "text": TEXT}         0: to all
///   {"tag": 7, "op": "begin", "scene": NAME}                    gives seats; "": takes them back
struct ClassCommand {
  enum class Op { kMake, kRename, kWithdraw, kLink, kDelete, kSay, kBegin };
  static constexpr std::size_t kMostNames = 200;
  static constexpr std::size_t kLongestText = 480;  ///< bytes
  std::uint32_t tag = 0;                            ///< by which the page knows the answer
  Op op = Op::kSay;
  std::int64_t person = 0;
  std::vector<std::string> names;
  Access role = Access::kDrive;
  std::string text;
  std::string scene;
};
/// "person_make" and so on.
std::string_view ClassOpName(ClassCommand::Op op);
inline bool ChangesTokens(ClassCommand::Op op) {
  return op < ClassCommand::Op::kSay;
}
/// Throws Error for what is none.
ClassCommand ParseClassCommand(std::string_view json);

/// The seats of a scene that are served, in their order: NAME-1, NAME-2, ...
std::vector<std::string> SeatsOf(const std::string& scene, const std::set<std::string>& scenes);

/// The people of a course as the gateway has them: their tokens, seats, and what they are told.
/// Seats and lines are of this run of the gateway; people are in the course's file.
/// Thread contract: the network thread.
class ClassRoom {
 public:
  using Scenes = std::set<std::string>;
  /// How many pages somebody has open.
  using Here = std::function<int(std::int64_t person)>;
  /// A trial of theirs is recorded or scored.
  using Busy = std::function<bool(std::int64_t person)>;

  /// Throws Error, as CourseFile does.
  explicit ClassRoom(const std::string& folder);

  CourseFile& file() { return file_; }
  Roster& roster() { return roster_; }
  /// A teacher's token, where nobody may operate yet.
  std::optional<Roster::Made> MakeFirstTeacher();
  /// Adds those of the course to those of --tokens.  Throws Error where two are one station.
  Tokens With(Tokens others) const;

  /// Does it, and returns what the page that asked is answered: {tag, refusal, note, people}.
  /// @param others  the tokens of --tokens, whose names are taken.
  std::string Do(const ClassCommand& command, const Tokens& others, const Scenes& scenes,
                 const Here& here, const Busy& busy);
  /// Somebody has come: a free seat is theirs, where the class has begun.
  void Enter(std::int64_t person, const Scenes& scenes);
  /// Where they are to drive; empty: wherever they like.
  std::string SeatOf(std::int64_t person) const;
  /// Why they may do nothing in a scene; empty: they may.  @param person  none who teaches.
  std::string WhyNotAt(std::int64_t person, const std::string& scene) const;

  /// For teachers: everybody.  @param prefix  of the stations that are named after tokens.
  std::string PeopleJson(const Here& here, const std::string& prefix) const;
  /// For the person: {person, name, role, seat, line, lines}, with the number of lines so far.
  std::string OwnJson(std::int64_t person) const;

 private:
  struct Told {
    std::string seat;
    std::string line;
    std::uint64_t lines = 0;
  };
  void Say(std::int64_t person, const std::string& text);
  void Delete(std::int64_t person, const Busy& busy);
  /// Returns what a teacher should know of it.
  std::string Begin(const std::string& scene, const Scenes& scenes, const Here& here);

  const std::string folder_;
  CourseFile file_;
  Roster roster_;
  std::string scene_;  // whose seats are given; empty: none are
  std::map<std::int64_t, Told> told_;
};

}  // namespace palpate
