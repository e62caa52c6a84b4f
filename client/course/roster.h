#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/access.h"
#include "client/course/course_file.h"

namespace palpate {

/// A person of a course.  Only the hash of the token is stored.
struct Person {
  std::int64_t id = 0;  ///< from 1, never reused
  std::string name;     ///< printable UTF-8, at most Roster::kLongestName bytes
  Access role = Access::kDrive;
  TokenHash hash{};
  std::int64_t made_s = 0;       ///< since 1970
  std::int64_t withdrawn_s = 0;  ///< 0: is in the course
  bool here() const { return withdrawn_s == 0; }
};

/// The people of a course, stored in its file, with their roles.  A withdrawn person keeps id and
/// name, under which the trials are filed.  No two people who are not withdrawn may have names that
/// give the same station name (StationNameOf), regardless of case.  Every failure throws an Error,
/// worded with a remedy for whoever asked, and changes nothing.
/// Thread contract: one thread.
class Roster {
 public:
  static constexpr std::size_t kLongestName = 64;  ///< bytes
  static constexpr std::size_t kMost = 1000;       ///< people who are not withdrawn

  /// A new or renewed person with the token, which is available only here.
  struct Made {
    Person person;
    std::string token;
  };

  explicit Roster(CourseFile& file);

  /// Adds all of the people or, if one cannot be added, none.  White space at both ends of a
  /// name is ignored.
  std::vector<Made> Make(const std::vector<std::string>& names, Access role);
  void Rename(std::int64_t id, const std::string& name);
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
  /// Finds a person who is not withdrawn, by id or by token; null: there is none.
  const Person* Find(std::int64_t id) const;
  const Person* FindToken(std::string_view token) const;
  bool has_operator() const;

 private:
  /// Returns the name as it is stored.  @param id  the person who is to have it; 0: a new one
  std::string Checked(std::string_view name, std::int64_t id) const;
  const Person& Known(std::int64_t id) const;

  CourseFile& file_;
  std::vector<Person> people_;
};

}  // namespace palpate
