#include "client/viewer/class_room.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/course/person_data.h"
#include "client/viewer/page_messages.h"
#include "common/error.h"
#include "common/json/json_file.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

/// In the order of ClassCommand::Op.
const std::vector<std::string_view> kOps = {"person_make", "person_rename", "person_withdraw",
                                            "person_link", "person_delete", "say",
                                            "begin"};

std::string ShortText(const JsonNode& node, std::size_t most) {
  std::string text = node.Text();
  if (text.size() > most) node.Fail(fmt::format("has more than {} bytes; give fewer", most));
  return text;
}

std::int64_t IdIn(const JsonNode& json, std::int64_t least) {
  return json.At("person").Integer(least, std::numeric_limits<std::int32_t>::max());
}

}  // namespace

std::string_view ClassOpName(ClassCommand::Op op) {
  return kOps.at(static_cast<std::size_t>(op));
}

std::vector<std::string> SeatsOf(const std::string& scene, const std::set<std::string>& scenes) {
  std::vector<std::string> seats;
  for (int number = 1;; ++number) {
    std::string seat = fmt::format("{}-{}", scene, number);
    if (!scenes.contains(seat)) return seats;
    seats.push_back(std::move(seat));
  }
}

ClassCommand ParseClassCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/class");
  ClassCommand command;
  const std::string op = json.At("op").OneOf(kOps);
  command.op = static_cast<ClassCommand::Op>(std::ranges::find(kOps, op) - kOps.begin());
  command.tag = static_cast<std::uint32_t>(
      json.At("tag").Integer(0, std::numeric_limits<std::uint32_t>::max()));
  switch (command.op) {
    case ClassCommand::Op::kMake: {
      json.AllowOnly({"tag", "op", "names", "role"});
      const std::vector<JsonNode> names = json.At("names").Items(1);
      if (names.size() > ClassCommand::kMostNames) {
        json.At("names").Fail(fmt::format("has more than {}", ClassCommand::kMostNames));
      }
      for (const JsonNode& name : names) command.names.push_back(name.Text());
      command.role = *ParseRole(json.At("role").OneOf({"watch", "drive", "operate"}));
      break;
    }
    case ClassCommand::Op::kRename:
      json.AllowOnly({"tag", "op", "person", "name"});
      command.person = IdIn(json, 1);
      command.names.push_back(json.At("name").Text());
      break;
    case ClassCommand::Op::kWithdraw:
    case ClassCommand::Op::kLink:
    case ClassCommand::Op::kDelete:
      json.AllowOnly({"tag", "op", "person"});
      command.person = IdIn(json, 1);
      break;
    case ClassCommand::Op::kSay:
      json.AllowOnly({"tag", "op", "person", "text"});
      command.person = IdIn(json, 0);
      command.text = ShortText(json.At("text"), ClassCommand::kLongestText);
      break;
    case ClassCommand::Op::kBegin:
      json.AllowOnly({"tag", "op", "scene"});
      command.scene = ShortText(json.At("scene"), 64);
      break;
  }
  return command;
}

ClassRoom::ClassRoom(const std::string& folder) : folder_(folder), file_(folder), roster_(file_) {
  FinishDeletions(file_, folder_);
}

std::optional<Roster::Made> ClassRoom::MakeFirstTeacher() {
  if (roster_.has_operator()) return std::nullopt;
  return roster_.Make({"teacher"}, Access::kOperate).front();
}

Tokens ClassRoom::With(Tokens others) const {
  for (const Person& person : roster_.people()) {
    if (person.here()) {
      others.Add({person.role, person.name, person.hash, person.id, person.station});
    }
  }
  return others;
}

std::string ClassRoom::Do(const ClassCommand& command, const Tokens& others, const Scenes& scenes,
                          const Here& here, const Busy& busy) {
  std::string refusal, note;
  Json people = Json::array();
  const auto hand_out = [&](const Roster::Made& made) {
    people.push_back(
        {{"person", made.person.id}, {"name", made.person.name}, {"token", made.token}});
  };
  const Roster::IsTaken is_taken = [&](const std::string& station) {
    return others.NamesAnother(station, "", "");
  };
  try {
    for (const std::string& name : command.names) {
      if (const std::string like = others.NameLike(name); !like.empty()) {
        throw Error(Quoted(name) + " looks like " + Quoted(like) +
                    " in --tokens; give another name");
      }
    }
    switch (command.op) {
      case ClassCommand::Op::kMake:
        for (const Roster::Made& made : roster_.Make(command.names, command.role, is_taken)) {
          hand_out(made);
        }
        break;
      case ClassCommand::Op::kRename:
        roster_.Rename(command.person, command.names.front(), is_taken);
        break;
      case ClassCommand::Op::kWithdraw:
        roster_.Withdraw(command.person);
        announced_.erase(command.person);
        break;
      case ClassCommand::Op::kLink:
        hand_out(roster_.Renew(command.person));
        break;
      case ClassCommand::Op::kDelete:
        Delete(command.person, busy);
        break;
      case ClassCommand::Op::kSay:
        Say(command.person, command.text);
        break;
      case ClassCommand::Op::kBegin:
        note = Begin(command.scene, scenes, here);
        break;
    }
  } catch (const Error& error) {
    refusal = error.what();
  }
  return ToText(
      Json({{"tag", command.tag}, {"refusal", refusal}, {"note", note}, {"people", people}}));
}

void ClassRoom::Delete(std::int64_t id, const Busy& busy) {
  const std::string name = roster_.MayGo(id).name;
  if (busy(id)) {
    throw Error("a trial of " + Quoted(name) + " is running, or is being scored; end it first");
  }
  announced_.erase(id);
  try {
    DeletePerson(file_, folder_, id);
  } catch (const Error&) {
    roster_.Read();  // the person may be gone although files are left
    throw;
  }
  roster_.Read();
}

void ClassRoom::Say(std::int64_t id, const std::string& text) {
  if (id != 0 && roster_.Find(id) == nullptr) {
    throw Error(fmt::format("no person of this course has the number {}", id));
  }
  for (const Person& person : roster_.people()) {
    // A line to all is meant for students.
    const bool is_meant = id == 0 ? person.role != Access::kOperate : person.id == id;
    if (!person.here() || !is_meant) continue;
    Announced& announced = announced_[person.id];
    announced.line = text;
    ++announced.lines;
  }
}

std::string ClassRoom::Begin(const std::string& scene, const Scenes& scenes, const Here& here) {
  const std::size_t seats = SeatsOf(scene, scenes).size();
  if (!scene.empty() && seats == 0) {
    throw Error("scene " + Quoted(scene) +
                " has no seats; start palpate-server with --seats and their number");
  }
  if (scene != scene_) {
    for (auto& [id, announced] : announced_) announced.seat.clear();
  }
  scene_ = scene;
  if (scene.empty()) return "";
  // Connected people come first.
  std::vector<std::int64_t> drivers;
  for (const bool first : {true, false}) {
    for (const Person& person : roster_.people()) {
      const bool drives = person.here() && person.role == Access::kDrive;
      if (drives && (here(person.id) > 0) == first) drivers.push_back(person.id);
    }
  }
  for (const std::int64_t id : drivers) Enter(id, scenes);
  if (drivers.size() <= seats) return "";
  return fmt::format("{} of {} have no seat: the server has {} (palpate-server --seats)",
                     drivers.size() - seats, drivers.size(), seats);
}

void ClassRoom::Enter(std::int64_t id, const Scenes& scenes) {
  const Person* const person = roster_.Find(id);
  if (scene_.empty() || person == nullptr || person->role != Access::kDrive) return;
  Announced& announced = announced_[id];
  if (!announced.seat.empty()) return;
  for (const std::string& seat : SeatsOf(scene_, scenes)) {
    const bool taken = std::ranges::any_of(
        announced_, [&](const auto& entry) { return entry.second.seat == seat; });
    if (taken) continue;
    announced.seat = seat;
    return;
  }
}

std::string ClassRoom::SeatOf(std::int64_t person) const {
  const auto announced = announced_.find(person);
  return announced == announced_.end() ? "" : announced->second.seat;
}

std::int64_t ClassRoom::OwnerOf(const std::string& seat) const {
  const auto owner = std::ranges::find_if(
      announced_, [&](const auto& entry) { return entry.second.seat == seat; });
  return seat.empty() || owner == announced_.end() ? 0 : owner->first;
}

std::string ClassRoom::WhyNotAt(std::int64_t person, const std::string& scene) const {
  const std::string own = SeatOf(person);
  if (own == scene) return "";
  if (!own.empty()) return "your seat is '" + own + "'; take the tool there";
  return OwnerOf(scene) != 0
             ? "'" + scene + "' is the seat of another person, and you have none; ask your teacher"
             : "";
}

std::string ClassRoom::PeopleJson(const Here& here,
                                  const std::map<std::int64_t, TrialRoom::News>& trials,
                                  const std::vector<Exercise>& exercises,
                                  const std::string& prefix) const {
  Json people = Json::array();
  for (const Person& person : roster_.people()) {
    if (!person.here()) continue;
    people.push_back({{"person", person.id},
                      {"name", person.name},
                      {"role", RoleName(person.role)},
                      {"station", StationNameOf(prefix + person.station)},
                      {"here", here(person.id)},
                      {"seat", SeatOf(person.id)},
                      {"trial", nullptr}});
    const auto trial = trials.find(person.id);
    if (trial == trials.end()) continue;
    const TrialRoom::News& news = trial->second;
    people.back()["trial"] = {{"exercise", news.exercise}, {"n", news.n},
                              {"phase", news.phase},       {"ahead", news.ahead},
                              {"reason", news.reason},     {"points", nullptr}};
    const auto exercise = std::ranges::find(exercises, news.exercise, &Exercise::name);
    if (exercise != exercises.end()) people.back()["trial"]["title"] = Json(exercise->title);
    if (news.points) people.back()["trial"]["points"] = *news.points;
  }
  return ToText(Json({{"scene", scene_}, {"people", people}}));
}

std::string ClassRoom::OwnJson(std::int64_t id,
                               const std::map<std::string, std::string>& names) const {
  const Person* const person = roster_.Find(id);
  if (person == nullptr) return "{}";
  const auto announced = announced_.find(id);
  const Announced own = announced == announced_.end() ? Announced{} : announced->second;
  return ToText(Json({{"person", id},
                      {"name", person->name},
                      {"role", RoleName(person->role)},
                      {"seat", own.seat},
                      {"line", own.line},
                      {"lines", own.lines},
                      {"names", names}}));
}

}  // namespace palpate
