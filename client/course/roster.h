#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/access.h"
#include "client/course/roster_table.h"

namespace palpate {

/// The people of a course, stored in its file, with their roles.  A withdrawn person keeps id and
/// name, under which the trials are filed.  No two people who are not withdrawn may have names that
/// look alike (NameLook), nor the same station.  Every failure throws an Error, worded with a
/// remedy for whoever asked, and changes nothing.
/// Thread contract: one thread.
class Roster {
 public:
  /// Returns whether a station's name is somebody else's, who is not in the course.
  using IsTaken = std::function<bool(const std::string& station)>;

  /// A new or renewed person with the token, which is available only here.
  struct Made {
    Person person;
    std::string token;
  };

  explicit Roster(CourseFile& file);

  /// Adds all of the people or, if one cannot be added, none.
  std::vector<Made> Make(const std::vector<std::string>& names, Access role,
                         const IsTaken& is_taken = {});
  void Rename(std::int64_t id, const std::string& name, const IsTaken& is_taken = {});
  /// Ends the person's token.  The last operator cannot be withdrawn.
  void Withdraw(std::int64_t id);
  /// Returns the person, withdrawn or not.  Throws Error if there is no such person, or if
  /// they must stay.
  const Person& MayGo(std::int64_t id) const;
  /// Gives the person a new token in place of one that is lost or has become known to others.
  Made Renew(std::int64_t id);

  /// Reads the file again, in case another process has changed it.
  void Read();
  /// All people by id, including the withdrawn.
  const std::vector<Person>& people() const { return people_; }
  /// Finds a person who is not withdrawn; null: there is none.
  const Person* Find(std::int64_t id) const;
  /// Finds a person who is not withdrawn by a name that looks like theirs; null: there is none, or
  /// there are several.
  const Person* FindName(std::string_view name) const;
  /// Returns the name of a person who is not withdrawn that somebody who wrote `name` most likely
  /// meant; empty: none is near.
  std::string NameNear(std::string_view name) const;
  bool has_operator() const;

 private:
  /// Gives a person a name, as it is stored, and a look.  @param one  with the number; 0: a new one
  void Name(Person& one, std::string_view name) const;
  std::string StationFor(const Person& one, const IsTaken& is_taken) const;
  const Person& Known(std::int64_t id) const;

  CourseFile& file_;
  RosterTable table_;
  std::vector<Person> people_;
};

}  // namespace palpate
