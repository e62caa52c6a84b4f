#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/access.h"
#include "client/course/course_file.h"

namespace palpate {

/// Somebody of a course.  Of the token only the hash is known.
struct Person {
  std::int64_t id = 0;  ///< from 1, never another's
  std::string name;     ///< printable UTF-8, at most Roster::kLongestName bytes
  Access role = Access::kDrive;
  TokenHash hash{};
  std::int64_t made_s = 0;       ///< since 1970
  std::int64_t withdrawn_s = 0;  ///< 0: is one of the course
  bool here() const { return withdrawn_s == 0; }
};

/// The people of a course, in its file: who they are and what they may.  Who is withdrawn
/// keeps id and name, under which trials are filed.  Of those who are not withdrawn no two have
/// names that are one station's (StationNameOf), in small or capital letters. Everything throws
/// Error with a remedy, for whoever asked, and then has changed nothing. Thread contract: one
/// thread.
class Roster {
 public:
  static constexpr std::size_t kLongestName = 64;  ///< bytes
  static constexpr std::size_t kMost = 1000;       ///< people who are not withdrawn

  /// The token is told here and nowhere else.
  struct Made {
    Person person;
    std::string token;
  };

  explicit Roster(CourseFile& file);

  /// All of them or, where one cannot be, none.  A name's spaces at both ends do not count.
  std::vector<Made> Make(const std::vector<std::string>& names, Access role);
  void Rename(std::int64_t id, const std::string& name);
  /// Ends the token.  The last one who may operate stays.
  void Withdraw(std::int64_t id);
  /// Whoever it is, the withdrawn too.  Throws Error where there is nobody, or who must stay.
  const Person& MayGo(std::int64_t id) const;
  /// Another token in the former's place, which is lost or known to others.
  Made Renew(std::int64_t id);

  /// Reads the file again, which another process may have changed.
  void Read();
  /// By id, the withdrawn too.
  const std::vector<Person>& people() const { return people_; }
  /// Of those who are not withdrawn; null: nobody's.
  const Person* Find(std::int64_t id) const;
  const Person* FindToken(std::string_view token) const;
  bool has_operator() const;

 private:
  /// The name as it is kept.  @param id  whose it is to be; 0: a new one's
  std::string Checked(std::string_view name, std::int64_t id) const;
  const Person& Known(std::int64_t id) const;

  CourseFile& file_;
  std::vector<Person> people_;
};

}  // namespace palpate
