#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <SQLiteCpp/SQLiteCpp.h>

#include "client/course/access.h"
#include "client/course/course_file.h"

// One statement on a course's file.  Only the sources of its tables include this: nothing else
// knows SQL.
namespace palpate {

/// Binds a value to a parameter; nothing: NULL.
template <class Value>
void Bind(SQLite::Statement& statement, int at, const Value& value) {
  if constexpr (std::is_same_v<Value, TokenHash>) {
    statement.bind(at, value.data(), static_cast<int>(value.size()));
  } else if constexpr (requires { value.has_value(); }) {
    if (value) statement.bind(at, *value);
  } else {
    statement.bind(at, value);
  }
}

/// Runs a query, or a change with RETURNING, and returns its rows.
/// @param row_of  reads one: Row(SQLite::Statement&).   @param values  of the parameters, in order.
/// Throws Error as CourseFile::Use does.
template <class RowOf, class... Values>
auto Rows(CourseFile& file, const std::string& sql, RowOf row_of, const Values&... values) {
  std::vector<std::invoke_result_t<RowOf, SQLite::Statement&>> rows;
  file.Use([&](SQLite::Database& database) {
    SQLite::Statement statement(database, sql);
    int at = 0;
    (Bind(statement, ++at, values), ...);
    while (statement.executeStep()) rows.push_back(row_of(statement));
  });
  return rows;
}

/// Runs a change.  Returns how many rows it has changed.
template <class... Values>
int Run(CourseFile& file, const std::string& sql, const Values&... values) {
  int changed = 0;
  file.Use([&](SQLite::Database& database) {
    SQLite::Statement statement(database, sql);
    int at = 0;
    (Bind(statement, ++at, values), ...);
    changed = statement.exec();
  });
  return changed;
}

/// Reads rows of one number.
inline std::int64_t NumberIn(SQLite::Statement& row) {
  return row.getColumn(0).getInt64();
}

}  // namespace palpate
