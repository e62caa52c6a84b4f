#include "client/course/roster.h"

#include <algorithm>
#include <cstring>
#include <ctime>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <openssl/crypto.h>

#include "common/error.h"
#include "common/text/lower_case.h"
#include "common/text/nearest_word.h"
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
  person.station = row.getColumn(6).getString();
  person.look = LookOf(person.name);
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
        "SELECT id, name, role, token_sha256, made_s, withdrawn_s, station FROM person "
        "ORDER BY id");
    while (rows.executeStep()) people.push_back(PersonOf(rows));
  });
  people_ = std::move(people);
}

void Roster::Name(Person& one, std::string_view name) const {
  one.name = PersonName(name);
  one.look = LookOf(one.name);
  for (const Person& other : people_) {
    if (!other.here() || other.id == one.id || !LookAlike(one.look, other.look)) continue;
    throw Error(
        other.name == one.name
            ? fmt::format("there is already a {}; add a letter or number to tell them apart",
                          Quoted(one.name))
            : fmt::format("{} looks like {}, who is in the course; add a letter or number to tell "
                          "them apart",
                          Quoted(one.name), Quoted(other.name)));
  }
}

std::string Roster::StationFor(const Person& one, const IsTaken& is_taken) const {
  // Room for a prefix, mouse_, and the number of a second page, _123 (MouseRoom).
  constexpr std::size_t kLongest = kLongestStation - 10;
  const auto is_free = [&](const std::string& station) {
    return !station.empty() && station.size() <= kLongest && !(is_taken && is_taken(station)) &&
           std::ranges::none_of(people_, [&](const Person& other) {
             return other.here() && other.id != one.id &&
                    LowerCase(other.station) == LowerCase(station);
           });
  };
  const std::string latin = InLatin(one.name);
  std::string station = latin;
  std::string after = "_" + std::to_string(one.id);
  while (!is_free(station)) {
    const std::string begin = latin.empty() ? "person" : latin;
    station = begin.substr(0, kLongest - after.size()) + after;
    after += "_";  // somebody's name is this one with this number
  }
  return station;
}

const Person& Roster::Known(std::int64_t id) const {
  if (const Person* const person = Find(id)) return *person;
  throw Error(fmt::format("no person of this course has the number {}; reload the page", id));
}

std::vector<Roster::Made> Roster::Make(const std::vector<std::string>& names, Access role,
                                       const IsTaken& is_taken) {
  const auto here = std::ranges::count_if(people_, &Person::here);
  if (static_cast<std::size_t>(here) + names.size() > kMost) {
    throw Error(fmt::format("a course has at most {} people; remove some", kMost));
  }
  std::vector<Made> made;
  const std::vector<Person> before = people_;
  try {
    file_.Use([&](SQLite::Database& database) {
      SQLite::Transaction transaction(database);
      // The number is known once the row is there.
      SQLite::Statement insert(database,
                               "INSERT INTO person(name, station, role, token_sha256, made_s) "
                               "VALUES(?, '', ?, ?, ?)");
      SQLite::Statement update(database, "UPDATE person SET station = ? WHERE id = ?");
      for (const std::string& name : names) {
        Made one{{}, RandomToken()};
        Name(one.person, name);
        one.person.role = role;
        one.person.hash = HashOfToken(one.token);
        one.person.made_s = std::time(nullptr);
        insert.reset();
        insert.bind(1, one.person.name);
        insert.bind(2, RoleName(role));
        insert.bind(3, one.person.hash.data(), static_cast<int>(one.person.hash.size()));
        insert.bind(4, one.person.made_s);
        insert.exec();
        one.person.id = database.getLastInsertRowid();
        one.person.station = StationFor(one.person, is_taken);
        update.reset();
        update.bind(1, one.person.station);
        update.bind(2, one.person.id);
        update.exec();
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

void Roster::Rename(std::int64_t id, const std::string& name, const IsTaken& is_taken) {
  Person one = Known(id);
  Name(one, name);
  one.station = StationFor(one, is_taken);
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement update(database, "UPDATE person SET name = ?, station = ? WHERE id = ?");
    update.bind(1, one.name);
    update.bind(2, one.station);
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

const Person* Roster::FindName(std::string_view name) const {
  const NameLook look = LookOf(name);
  const Person* found = nullptr;
  bool is_one = false;
  for (const Person& person : people_) {
    if (!person.here() || !LookAlike(person.look, look)) continue;
    if (person.name == name) return &person;
    is_one = found == nullptr;
    found = &person;
  }
  return is_one ? found : nullptr;
}

std::string Roster::NameNear(std::string_view name) const {
  // In Latin, so that an accent or a script is no distance.
  const auto key_of = [](std::string_view of) {
    const std::string latin = LowerCase(InLatin(of));
    return latin.empty() ? std::string(of) : latin;
  };
  std::vector<std::string> keys(people_.size());
  for (std::size_t i = 0; i < people_.size(); ++i) {
    if (people_[i].here()) keys[i] = key_of(people_[i].name);
  }
  const std::vector<std::string_view> words(keys.begin(), keys.end());
  const std::string_view nearest = NearestWord(key_of(name), words);
  return nearest.empty() ? "" : people_[std::ranges::find(keys, nearest) - keys.begin()].name;
}

bool Roster::has_operator() const {
  return std::ranges::any_of(people_, [](const Person& person) {
    return person.here() && person.role == Access::kOperate;
  });
}

}  // namespace palpate
