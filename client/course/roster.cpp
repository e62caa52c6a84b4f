#include "client/course/roster.h"

#include <algorithm>
#include <ctime>

#include <fmt/format.h>

#include "common/error.h"
#include "common/text/lower_case.h"
#include "common/text/nearest_word.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::size_t kMost = 2000;  // people who are not withdrawn

}  // namespace

Roster::Roster(CourseFile& file) : file_(file), table_(file), people_(table_.All()) {}

void Roster::Read() {
  people_ = table_.All();
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
    file_.Whole([&] {
      for (const std::string& name : names) {
        Made one{{}, RandomToken()};
        Name(one.person, name);
        one.person.role = role;
        one.person.hash = HashOfToken(one.token);
        one.person.made_s = std::time(nullptr);
        one.person.id = table_.Add(one.person);
        one.person.station = StationFor(one.person, is_taken);
        table_.Rename(one.person.id, one.person.name, one.person.station);
        people_.push_back(one.person);  // so that the next name is checked against it too
        made.push_back(std::move(one));
      }
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
  table_.Rename(id, one.name, one.station);
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
  table_.Withdraw(id);
  Read();
}

Roster::Made Roster::Renew(std::int64_t id) {
  Made made{Known(id), RandomToken()};
  made.person.hash = HashOfToken(made.token);
  table_.Renew(id, made.person.hash);
  Read();
  return made;
}

const Person* Roster::Find(std::int64_t id) const {
  const auto found = std::ranges::find(people_, id, &Person::id);
  return found == people_.end() || !found->here() ? nullptr : &*found;
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
