#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/course/access.h"
#include "client/course/course_file.h"
#include "client/course/person_name.h"

namespace palpate {

/// A person of a course.  Only the hash of the token is stored.
struct Person {
  std::int64_t id = 0;  ///< from 1, never reused
  std::string name;     ///< as PersonName returns it
  Access role = Access::kDrive;
  TokenHash hash{};
  std::int64_t made_s = 0;       ///< since 1970
  std::int64_t withdrawn_s = 0;  ///< 0: is in the course
  std::string station;           ///< of their tools; ends with the number where a name does not do
  NameLook look;
  bool here() const { return withdrawn_s == 0; }
};

/// The tables `person` and `deleted`: people, and the numbers of those whose files are still to be
/// removed.
/// Thread contract: as CourseFile.  Every function throws Error as CourseFile::Use does.
class RosterTable {
 public:
  /// Creates the tables if they are missing.
  explicit RosterTable(CourseFile& file);

  /// Returns all people by id, including the withdrawn.
  std::vector<Person> All() const;
  /// Returns a person's name; empty: there is no such person, or it cannot be read.
  std::string NameOf(std::int64_t id) const;
  /// Adds a person without a station, whose name needs the number.  Returns the number.
  std::int64_t Add(const Person& person);
  void Rename(std::int64_t id, const std::string& name, const std::string& station);
  /// Enters that the person withdraws now.
  void Withdraw(std::int64_t id);
  void Renew(std::int64_t id, const TokenHash& hash);
  /// Deletes a person from every table of the course that has a column `person`, and enters the
  /// number as deleted.  SQLite overwrites what it deletes.
  void Delete(std::int64_t id);
  /// Returns who is deleted but for their files.
  std::vector<std::int64_t> Deleted() const;
  /// The files of a deleted person are removed, too.
  void Forget(std::int64_t id);

 private:
  CourseFile& file_;
};

}  // namespace palpate
