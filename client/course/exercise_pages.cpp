#include "client/course/exercise_pages.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/files/project_files.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Pages warn of a tissue to be spared at least from this distance on.
constexpr double kLeastWarning_mm = 0.5;

Json DescriptionOf(const Exercise& exercise) {
  Json pictures = Json::array();
  for (const Exercise::Picture& picture : exercise.pictures) {
    pictures.push_back(
        {{"path", "exercise/" + exercise.name + "/" + picture.file}, {"text", Json(picture.text)}});
  }
  Json guide = Json::array();
  for (const auto& [t, X, label] : exercise.guide) {
    guide.push_back({t, X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()});
  }
  double weights = 0.0;
  for (const Criterion& criterion : exercise.criteria.criteria) weights += criterion.weight;
  Json graded = Json::array();
  for (const Criterion& criterion : exercise.criteria.criteria) {
    graded.push_back({{"name", Json(criterion.names)},
                      {"points", 100.0 * criterion.weight / weights},
                      {"gates", criterion.gates},
                      {"harms", criterion.harms}});
  }
  Json guards = Json::array();
  for (const Criterion& criterion : exercise.criteria.criteria) {
    if (criterion.measure != "thickness_mm") continue;
    guards.push_back(
        {{"tissue", criterion.tissue}, {"within_mm", std::max(criterion.best, kLeastWarning_mm)}});
  }
  const char* const starts[] = {"whole", "bookmark", "as_it_is"};
  return {{"name", exercise.name},
          {"title", Json(exercise.title)},
          {"scene", exercise.scene_name},
          {"tool", exercise.tool},
          {"tools", exercise.tools},
          {"start", starts[static_cast<int>(exercise.start)]},
          {"instruction", Json(exercise.instruction)},
          {"goal", Json(exercise.goal)},
          {"pictures", pictures},
          {"most_N", exercise.most_N},
          {"most_s", exercise.most_s},
          {"trials", exercise.trials},
          {"pass", exercise.criteria.pass},
          {"graded", graded},
          {"sources", exercise.sources},
          {"guide", guide},
          {"guards", guards},
          {"done", Json::array()}};
}

}  // namespace

ExercisePages::ExercisePages(std::string folder, const TrialTable& trials)
    : folder_(std::move(folder)), trials_(trials) {
  const auto refused = [](const std::string& why) {
    spdlog::error("{} (this exercise is skipped)", Printable(why));
  };
  exercises_ = LoadExercises(folder_ + "/exercises", refused);
  for (Exercise& shipped : LoadExercises(PlaceOf(ProjectFile::kExercises), refused)) {
    if (Find(shipped.name) == nullptr) exercises_.push_back(std::move(shipped));
  }
}

const Exercise* ExercisePages::Find(const std::string& exercise) const {
  const auto found = std::ranges::find(exercises_, exercise, &Exercise::name);
  return found == exercises_.end() ? nullptr : &*found;
}

std::string ExercisePages::FolderOf(std::int64_t person, const std::string& exercise) const {
  return fmt::format("{}/trials/{}/{}", folder_, person, exercise);
}

std::string ExercisePages::PageFileOf(const TrialKey& trial) const {
  return fmt::format("{}/{}/score.html", FolderOf(trial.person, trial.exercise), trial.n);
}

bool ExercisePages::HasPage(const TrialRow& row) const {
  std::error_code none;
  return fs::exists(PageFileOf(row.key()), none);
}

std::string ExercisePages::KeyOf(const TrialKey& trial) {
  const std::string page = PageFileOf(trial);
  const auto known =
      std::ranges::find(pages_, page, [](const auto& entry) { return entry.second; });
  if (known != pages_.end()) return known->first;
  std::random_device random;
  std::string key;
  for (int i = 0; i < 4; ++i) key += fmt::format("{:08x}", random());
  return pages_.emplace(key, page).first->first;
}

std::map<std::pair<std::string, int>, std::string> ExercisePages::PagesOf(std::int64_t person) {
  std::map<std::pair<std::string, int>, std::string> pages;
  for (const TrialRow& row : trials_.Ended(person)) {
    if (HasPage(row)) pages[{row.exercise, row.n}] = KeyOf(row.key());
  }
  return pages;
}

void ExercisePages::Forget(const std::set<std::int64_t>& people) {
  for (const std::int64_t person : people) {
    const std::string theirs = FolderOf(person, "");
    std::erase_if(pages_, [&](const auto& entry) { return entry.second.starts_with(theirs); });
  }
}

std::string ExercisePages::PageOf(const std::string& key) const {
  const auto page = pages_.find(key);
  return page == pages_.end() ? "" : page->second;
}

std::string ExercisePages::PictureOf(const std::string& path) const {
  for (const Exercise& exercise : exercises_) {
    for (const Exercise::Picture& picture : exercise.pictures) {
      if (exercise.name + "/" + picture.file == path) {
        return exercise.folder() + "/" + picture.file;
      }
    }
  }
  return "";
}

std::string ExercisePages::DescribeJson(const std::string& exercise) const {
  Json json = DescriptionOf(*Find(exercise));
  for (const char* hint : {"guide", "guards"}) json.erase(hint);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string ExercisePages::ListJson(std::int64_t person, bool teaches) {
  Json list = Json::array();
  for (const Exercise& exercise : exercises_) {
    list.push_back(DescriptionOf(exercise));
    if (teaches) list.back()["serve"] = ShellWord(exercise.scene);
  }
  for (const TrialRow& row : trials_.Ended(person)) {
    const auto exercise = std::ranges::find(exercises_, row.exercise, &Exercise::name);
    if (exercise == exercises_.end()) continue;
    list[static_cast<std::size_t>(exercise - exercises_.begin())]["done"].push_back(
        {{"n", row.n},
         {"points", row.points ? Json(*row.points) : Json()},
         {"passed", row.passed},
         {"whole", row.whole},
         {"submitted", row.submitted_s.has_value()},
         {"reason", row.reason},
         {"page", HasPage(row) ? KeyOf(row.key()) : ""}});
  }
  return Json({{"exercises", list}}).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpate
