#include "client/course/roster.h"

#include <algorithm>
#include <cstring>
#include <ctime>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <openssl/crypto.h>

#include "common/error.h"
#include "common/text/lower_case.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr const char* kTable = R"(CREATE TABLE IF NOT EXISTS person(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  station TEXT NOT NULL COLLATE NOCASE,
  role TEXT NOT NULL,
  token_sha256 BLOB NOT NULL UNIQUE,
  made_s INTEGER NOT NULL,
  withdrawn_s INTEGER NOT NULL DEFAULT 0);
CREATE UNIQUE INDEX IF NOT EXISTS person_station ON person(station) WHERE withdrawn_s = 0)";

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
  return person;
}

}  // namespace

Roster::Roster(CourseFile& file) : file_(file) {
  file_.Use([](SQLite::Database& database) { database.exec(kTable); });
  Read();
}

void Roster::Read() {
  std::vector<Person> people;
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement rows(
        database,
        "SELECT id, name, role, token_sha256, made_s, withdrawn_s FROM person ORDER BY id");
    while (rows.executeStep()) people.push_back(PersonOf(rows));
  });
  people_ = std::move(people);
}

std::string Roster::Checked(std::string_view name, std::int64_t id) const {
  const std::string kept(Trimmed(name));
  if (kept.empty()) throw Error("the name is empty; give one");
  if (kept.size() > kLongestName) {
    throw Error(
        fmt::format("the name {} has more than {} bytes; shorten it", Quoted(kept), kLongestName));
  }
  if (Printable(kept) != kept) {
    throw Error(fmt::format("the name {} has invisible characters; type it again", Quoted(kept)));
  }
  const std::string station = StationNameOf(kept);
  if (station.find_first_not_of('_') == station.npos) {
    throw Error(fmt::format("the name {} has no letter or digit; add one", Quoted(kept)));
  }
  for (const Person& other : people_) {
    if (!other.here() || other.id == id) continue;
    if (LowerCase(StationNameOf(other.name)) != LowerCase(station)) continue;
    throw Error(
        other.name == kept
            ? fmt::format("there is already a {}; add a letter or number to tell them apart",
                          Quoted(kept))
            : fmt::format("{} and {} would have the same station name, '{}'; add a letter or "
                          "number to tell them apart",
                          Quoted(kept), Quoted(other.name), station));
  }
  return kept;
}

const Person& Roster::Known(std::int64_t id) const {
  if (const Person* const person = Find(id)) return *person;
  throw Error(fmt::format("no person of this course has the number {}; reload the page", id));
}

std::vector<Roster::Made> Roster::Make(const std::vector<std::string>& names, Access role) {
  const auto here = std::ranges::count_if(people_, &Person::here);
  if (static_cast<std::size_t>(here) + names.size() > kMost) {
    throw Error(fmt::format("a course has at most {} people; remove some", kMost));
  }
  std::vector<Made> made;
  const std::vector<Person> before = people_;
  try {
    file_.Use([&](SQLite::Database& database) {
      SQLite::Transaction transaction(database);
      SQLite::Statement insert(database,
                               "INSERT INTO person(name, station, role, token_sha256, made_s) "
                               "VALUES(?, ?, ?, ?, ?)");
      for (const std::string& name : names) {
        Made one{{0, Checked(name, 0), role, {}, std::time(nullptr), 0}, RandomToken()};
        one.person.hash = HashOfToken(one.token);
        insert.reset();
        insert.bind(1, one.person.name);
        insert.bind(2, StationNameOf(one.person.name));
        insert.bind(3, RoleName(role));
        insert.bind(4, one.person.hash.data(), static_cast<int>(one.person.hash.size()));
        insert.bind(5, static_cast<std::int64_t>(one.person.made_s));
        insert.exec();
        one.person.id = database.getLastInsertRowid();
        people_.push_back(one.person);  // so that the next name is checked against it too
        made.push_back(std::move(one));
      }
      transaction.commit();
    });
  } catch (const Error&) {
    people_ = before;
    throw;
  }
  return made;
}

void Roster::Rename(std::int64_t id, const std::string& name) {
  const std::string kept = Checked(name, Known(id).id);
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement update(database, "UPDATE person SET name = ?, station = ? WHERE id = ?");
    update.bind(1, kept);
    update.bind(2, StationNameOf(kept));
    update.bind(3, id);
    update.exec();
  });
  Read();
}

const Person& Roster::MayGo(std::int64_t id) const {
  const auto found = std::ranges::find(people_, id, &Person::id);
  const Person& person = found == people_.end() ? Known(id) : *found;
  const auto operates = [](const Person& one) {
    return one.here() && one.role == Access::kOperate;
  };
  if (operates(person) && std::ranges::count_if(people_, operates) == 1) {
    throw Error(
        fmt::format("{} is the last person with the role 'operate', and nobody could undo this; "
                    "give another person that role first",
                    Quoted(person.name)));
  }
  return person;
}

void Roster::Withdraw(std::int64_t id) {
  MayGo(Known(id).id);
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement update(database, "UPDATE person SET withdrawn_s = ? WHERE id = ?");
    update.bind(1, static_cast<std::int64_t>(std::time(nullptr)));
    update.bind(2, id);
    update.exec();
  });
  Read();
}

Roster::Made Roster::Renew(std::int64_t id) {
  Made made{Known(id), RandomToken()};
  made.person.hash = HashOfToken(made.token);
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement update(database, "UPDATE person SET token_sha256 = ? WHERE id = ?");
    update.bind(1, made.person.hash.data(), static_cast<int>(made.person.hash.size()));
    update.bind(2, id);
    update.exec();
  });
  Read();
  return made;
}

const Person* Roster::Find(std::int64_t id) const {
  const auto found = std::ranges::find(people_, id, &Person::id);
  return found == people_.end() || !found->here() ? nullptr : &*found;
}

const Person* Roster::FindToken(std::string_view token) const {
  if (!LooksLikeToken(token)) return nullptr;
  const TokenHash hash = HashOfToken(token);
  const Person* found = nullptr;
  for (const Person& person : people_) {  // constant time: all are compared
    if (CRYPTO_memcmp(person.hash.data(), hash.data(), hash.size()) == 0) found = &person;
  }
  return found != nullptr && found->here() ? found : nullptr;
}

bool Roster::has_operator() const {
  return std::ranges::any_of(people_, [](const Person& person) {
    return person.here() && person.role == Access::kOperate;
  });
}

}  // namespace palpate
