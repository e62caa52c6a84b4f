#include "client/course/exercise.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "common/text/joined.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_file.h"
#include "scenes/shapes/shape_kinds.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest_s = 3600.0;
constexpr int kMostTrials = 100;

/// Reads the path of a file in the exercise's folder or below.
std::string ReadBeside(const JsonNode& node, const std::string& folder) {
  const fs::path path = fs::path(node.String()).lexically_normal();
  if (path.is_absolute() || *path.begin() == "..") {
    node.Fail("is not in the exercise's folder; put it there, and give a path relative to it");
  }
  std::error_code ignored;
  if (!fs::is_regular_file(folder / path, ignored)) {
    node.Fail("there is no file " + (folder / path).string() + "; put it there, or name another");
  }
  return path.string();
}

Exercise::Picture ReadPicture(const JsonNode& node, const std::string& folder) {
  node.AllowOnly({"file", "text"});
  const JsonNode file = node.At("file");
  static const std::set<std::string> kKinds = {".png", ".jpg", ".svg", ".webp"};
  Exercise::Picture picture{ReadBeside(file, folder), ReadLocalText(node.At("text"))};
  if (!kKinds.contains(fs::path(picture.file).extension().string())) {
    file.Fail("is not a picture that browsers show; give a .png, .jpg, .svg or .webp");
  }
  return picture;
}

/// The facts about its scene that an exercise is checked against.
struct SceneFacts {
  SceneDescription scene;
  std::vector<std::string> tissues;  ///< names of what can be cut
  std::vector<std::string> painted;  ///< those that regions paint

  explicit SceneFacts(const std::string& file)
      : scene(ParseScene(ReadWholeFile(file, JsonNode::kMostBytes), file)) {
    for (const BodyDescription& body : scene.objects) {
      if (!body.grid) continue;
      const auto name = [&](const MaterialDescription& of) {
        return of.material.name.empty() ? body.name : of.material.name;
      };
      tissues.push_back(name(body.material));
      for (const RegionDescription& region : body.regions) {
        painted.push_back(name(region.material));
        tissues.push_back(painted.back());
      }
    }
  }
  const BodyDescription* Find(const std::string& tool) const {
    const auto found = std::ranges::find(scene.tools, tool, &BodyDescription::name);
    return found == scene.tools.end() ? nullptr : &*found;
  }
};

std::string Listed(const std::vector<std::string>& names) {
  return names.empty() ? "nothing" : Joined(std::set(names.begin(), names.end()));
}

bool Cuts(const BodyDescription& tool) {
  const ShapeKind* kind =
      tool.mesh.kind == MeshSource::Kind::kShape ? FindShapeKind(tool.mesh.what) : nullptr;
  return tool.edge || (kind != nullptr && kind->bur);
}

/// Fails if the scene lacks what a criterion measures, since everybody would then get its worst.
void CheckMeasures(const JsonNode& criteria, const SceneFacts& facts, const std::string& tool) {
  for (const JsonNode& node : criteria.At("criteria").Items()) {
    const JsonNode measure = node.At("measure");
    if (!MeasureOf(measure.String()).of_cut) continue;
    if (facts.tissues.empty() || !Cuts(*facts.Find(tool))) {
      measure.Fail("measures a cut, but tool '" + tool + "' of scene '" + facts.scene.name +
                   "' cannot cut; use another measure, tool or scene");
    }
    const auto tissue = node.Find("tissue");
    if (!tissue) continue;
    const auto& there = measure.String() == "thickness_mm" ? facts.painted : facts.tissues;
    if (std::ranges::find(there, tissue->String()) == there.end()) {
      tissue->Fail("scene '" + facts.scene.name + "' has no such tissue" +
                   (measure.String() == "thickness_mm" ? " in a region" : "") +
                   "; there is: " + Listed(there));
    }
  }
}

/// Finds a scene file by its catalogue name, or by its path relative to the exercise's folder.
std::string SceneFileOf(const JsonNode& node, const std::string& folder) {
  std::string scene = node.String();
  if (scene.find('/') != std::string::npos || fs::path(scene).has_extension()) {
    scene = (fs::path(folder) / scene).lexically_normal().string();
    if (!scene.ends_with(".json"))
      node.Fail("is not a scene file; give NAME.json, or the name of a scene");
  }
  try {
    const std::string file = FindSceneFile(scene);
    std::error_code ignored;
    if (!fs::exists(file, ignored)) throw Error("there is no file " + file + "; name another");
  } catch (const Error& error) {
    node.Fail(error.what());
  }
  return scene;
}

void ReadLimits(const JsonNode& limits, Exercise& exercise) {
  limits.AllowOnly({"force_N", "time_s"});
  if (auto force = limits.Find("force_N")) exercise.most_N = force->PositiveNumber();
  exercise.most_s = limits.At("time_s").Number(1.0, kLongest_s);
}

/// Reads the texts and pictures shown to students.
void ReadTexts(const JsonNode& root, Exercise& exercise) {
  exercise.title = ReadLocalText(root.At("title"));
  exercise.goal = ReadLocalText(root.At("goal"));
  const JsonNode instruction = root.At("instruction");
  instruction.AllowOnly({"text", "pictures"});
  exercise.instruction = ReadLocalText(instruction.At("text"));
  if (auto pictures = instruction.Find("pictures")) {
    for (const JsonNode& picture : pictures->Items()) {
      exercise.pictures.push_back(ReadPicture(picture, exercise.folder()));
    }
  }
  if (auto sources = root.Find("sources")) {
    for (const JsonNode& source : sources->Items()) exercise.sources.push_back(source.String());
  }
}

void ReadCriteriaOf(const JsonNode& node, const SceneFacts& facts, Exercise& exercise) {
  std::string file = exercise.file;
  JsonNode criteria = node;
  if (node.IsString()) {
    file = (fs::path(exercise.folder()) / ReadBeside(node, exercise.folder())).string();
    criteria = JsonNode::Load(file);
  }
  exercise.criteria = ReadCriteria(criteria, file, exercise.title);
  CheckMeasures(criteria, facts, exercise.tool);
}

}  // namespace

std::string Exercise::folder() const {
  const fs::path parent = fs::path(file).parent_path();
  return parent.empty() ? "." : parent.string();
}

Exercise LoadExercise(const std::string& file) {
  if (!file.ends_with(kExerciseEnding)) {
    throw Error(file + ": the file of an exercise must be named NAME" + kExerciseEnding +
                "; name it so");
  }
  const JsonNode root = JsonNode::Load(file);
  root.AllowOnly({"title", "scene", "tool", "start", "instruction", "goal", "limits", "trials",
                  "expert", "guide", "criteria", "sources"});
  Exercise exercise;
  exercise.file = file;
  exercise.name = fs::path(file).filename().string();
  exercise.name.resize(exercise.name.size() - std::string_view(kExerciseEnding).size());
  if (exercise.name.empty() || exercise.name.size() > kLongestName ||
      !std::ranges::all_of(exercise.name, IsOfName)) {
    throw Error(file +
                ": the file's name identifies its trials, and may have at most 64 letters, digits, "
                "- _ or .; rename it");
  }
  ReadTexts(root, exercise);
  exercise.scene = SceneFileOf(root.At("scene"), exercise.folder());
  const SceneFacts facts(FindSceneFile(exercise.scene));
  exercise.scene_name = facts.scene.name;
  const JsonNode tool = root.At("tool");
  exercise.tool = tool.String();
  if (facts.Find(exercise.tool) == nullptr) {
    std::vector<std::string> tools;
    for (const BodyDescription& of : facts.scene.tools) tools.push_back(of.name);
    tool.Fail("scene '" + facts.scene.name + "' has no such tool; there is: " + Listed(tools));
  }
  exercise.tools = {exercise.tool};
  for (const BodyDescription& of : facts.scene.tools) {
    if (of.name != exercise.tool && Cuts(of) && Cuts(*facts.Find(exercise.tool))) {
      exercise.tools.push_back(of.name);
    }
  }
  if (auto start = root.Find("start")) {
    const std::string word = start->OneOf({"whole", "bookmark", "as_it_is"});
    exercise.start = word == "whole"      ? Exercise::Start::kWhole
                     : word == "bookmark" ? Exercise::Start::kBookmark
                                          : Exercise::Start::kAsItIs;
  }
  ReadLimits(root.At("limits"), exercise);
  exercise.trials = static_cast<int>(root.At("trials").Integer(1, kMostTrials));
  ReadCriteriaOf(root.At("criteria"), facts, exercise);
  if (auto expert = root.Find("expert")) {
    exercise.expert =
        (fs::path(exercise.folder()) / ReadBeside(*expert, exercise.folder())).string();
  } else {
    exercise.expert = ScriptFileBeside(exercise.scene);
    if (!fs::exists(exercise.expert)) {
      root.Fail("scene '" + facts.scene.name +
                "' has no script of its own; add \"expert\", the script of the expert's hand "
                "(NAME.path.json)");
    }
  }
  const PoseScript script = PoseScript::Load(exercise.expert);
  const auto guide = root.Find("guide");
  if (!guide || guide->Boolean()) exercise.guide = script.keys();
  return exercise;
}

Criteria LoadCriteria(const std::string& file) {
  if (file.ends_with(kExerciseEnding)) return LoadExercise(file).criteria;
  return ReadCriteria(JsonNode::Load(file), file);
}

std::vector<Exercise> LoadExercises(const std::string& folder,
                                    const std::function<void(const std::string&)>& refused) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (entry.path().string().ends_with(kExerciseEnding)) files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  std::vector<Exercise> exercises;
  for (const std::string& file : files) {
    try {
      exercises.push_back(LoadExercise(file));
    } catch (const std::exception& error) {  // of any kind: the other exercises are still read
      refused(error.what());
    }
  }
  return exercises;
}

}  // namespace palpate
