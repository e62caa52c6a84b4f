#include "client/course/roster_table.h"

#include <cstring>
#include <ctime>

#include "client/course/sql.inl"
#include "common/error.h"

namespace palpate {
namespace {

std::string TextIn(SQLite::Statement& row) {
  return row.getColumn(0).getString();
}

Person PersonOf(SQLite::Statement& row) {
  Person person;
  person.id = row.getColumn(0).getInt64();
  person.name = row.getColumn(1).getString();
  person.role = ParseRole(row.getColumn(2).getString()).value_or(Access::kNone);
  const SQLite::Column hash = row.getColumn(3);
  if (hash.getBytes() == static_cast<int>(person.hash.size())) {
    std::memcpy(person.hash.data(), hash.getBlob(), person.hash.size());
  }
  person.made_s = row.getColumn(4).getInt64();
  person.withdrawn_s = row.getColumn(5).getInt64();
  person.station = row.getColumn(6).getString();
  person.look = LookOf(person.name);
  return person;
}

}  // namespace

RosterTable::RosterTable(CourseFile& file) : file_(file) {
  file_.Use([](SQLite::Database& database) {
    database.exec(R"(CREATE TABLE IF NOT EXISTS person(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  station TEXT NOT NULL COLLATE NOCASE,
  role TEXT NOT NULL,
  token_sha256 BLOB NOT NULL UNIQUE,
  made_s INTEGER NOT NULL,
  withdrawn_s INTEGER NOT NULL DEFAULT 0);
CREATE UNIQUE INDEX IF NOT EXISTS person_station ON person(station) WHERE withdrawn_s = 0;
CREATE TABLE IF NOT EXISTS deleted(person INTEGER PRIMARY KEY))");
  });
}

std::vector<Person> RosterTable::All() const {
  return Rows(file_,
              "SELECT id, name, role, token_sha256, made_s, withdrawn_s, station FROM person "
              "ORDER BY id",
              PersonOf);
}

std::string RosterTable::NameOf(std::int64_t id) const try {
  const auto names = Rows(file_, "SELECT name FROM person WHERE id=?", TextIn, id);
  return names.empty() ? "" : names.front();
} catch (const Error&) {
  return "";
}

std::int64_t RosterTable::Add(const Person& person) {
  return Rows(file_,
              "INSERT INTO person(name, station, role, token_sha256, made_s) "
              "VALUES(?, '', ?, ?, ?) RETURNING id",
              NumberIn, person.name, RoleName(person.role), person.hash, person.made_s)
      .front();
}

void RosterTable::Rename(std::int64_t id, const std::string& name, const std::string& station) {
  Run(file_, "UPDATE person SET name = ?, station = ? WHERE id = ?", name, station, id);
}

void RosterTable::Withdraw(std::int64_t id) {
  const std::int64_t now_s = std::time(nullptr);
  Run(file_, "UPDATE person SET withdrawn_s = ? WHERE id = ?", now_s, id);
}

void RosterTable::Renew(std::int64_t id, const TokenHash& hash) {
  Run(file_, "UPDATE person SET token_sha256 = ? WHERE id = ?", hash, id);
}

void RosterTable::Delete(std::int64_t id) {
  file_.Use([](SQLite::Database& database) { database.exec("PRAGMA secure_delete=ON"); });
  file_.Whole([&] {
    // Each part of a course may have tables of its own.
    for (const std::string& table :
         Rows(file_,
              "SELECT m.name FROM sqlite_master m JOIN pragma_table_info(m.name) c "
              "WHERE m.type = 'table' AND c.name = 'person' AND m.name <> 'deleted'",
              TextIn)) {
      Run(file_, "DELETE FROM \"" + table + "\" WHERE person = ?", id);
    }
    Run(file_, "DELETE FROM person WHERE id = ?", id);
    Run(file_, "INSERT OR IGNORE INTO deleted(person) VALUES(?)", id);
  });
}

std::vector<std::int64_t> RosterTable::Deleted() const {
  return Rows(file_, "SELECT person FROM deleted", NumberIn);
}

void RosterTable::Forget(std::int64_t id) {
  Run(file_, "DELETE FROM deleted WHERE person = ?", id);
  // Earlier pages of the write-ahead log still contain the name.
  file_.Use([](SQLite::Database& database) { database.exec("PRAGMA wal_checkpoint(TRUNCATE)"); });
}

}  // namespace palpate
