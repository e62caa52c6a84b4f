#include "client/course/exam.h"

#include <algorithm>
#include <filesystem>

#include "client/course/person_name.h"
#include "client/course/sha256.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/files/whole_file.h"
#include "scenes/files/scene_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr double kLongestTask_s = 3600.0, kLongestExam_s = 8 * kLongestTask_s;
constexpr std::size_t kMostTasks = 50;
constexpr int kMostTrialsOfTask = 20;

ExamTask ReadTask(const JsonNode& node, const std::string& folder) {
  node.AllowOnly({"exercise", "time_s", "trials"});
  const JsonNode name = node.At("exercise");
  const std::string exercise = name.String();
  if (!std::ranges::all_of(exercise, IsOfName)) name.Fail("is no exercise's name");
  const std::string file = ExerciseFileOf(folder, exercise);
  if (std::error_code none; !fs::exists(file, none)) {
    name.Fail("there is no such exercise; put " + folder + "/exercises/" + exercise +
              kExerciseEnding + " there, or name another");
  }
  ExamTask task = HashedTask(LoadExercise(file));
  if (const auto time = node.Find("time_s")) task.time_s = time->Number(1.0, kLongestTask_s);
  if (const auto trials = node.Find("trials")) {
    task.trials = static_cast<int>(trials->Integer(1, kMostTrialsOfTask));
  }
  return task;
}

}  // namespace

std::string ExerciseFileOf(const std::string& folder, const std::string& exercise) {
  const std::string own = folder + "/exercises/" + exercise + kExerciseEnding;
  std::error_code none;  // a name too long, or a link to itself, counts as missing
  return fs::exists(own, none)
             ? own
             : PlaceOf(ProjectFile::kExercises) + "/" + exercise + kExerciseEnding;
}

ExamTask HashedTask(const Exercise& exercise) {
  ExamTask task;
  task.exercise = exercise.name;
  task.time_s = exercise.most_s;
  task.exercise_sha256 = Sha256OfFile(exercise.file).sha256;
  task.criteria_sha256 = Sha256OfFile(exercise.criteria.file).sha256;
  task.expert_sha256 = Sha256OfFile(exercise.expert).sha256;
  return task;
}

bool SameFiles(const ExamTask& a, const ExamTask& b) {
  return a.exercise_sha256 == b.exercise_sha256 && a.criteria_sha256 == b.criteria_sha256 &&
         a.expert_sha256 == b.expert_sha256;
}

Exam LoadExam(const std::string& file) {
  if (!file.ends_with(kExamEnding)) {
    throw Error(file + ": the file of an exam must be named NAME" + kExamEnding + "; name it so");
  }
  const std::string text = ReadWholeFile(file, JsonNode::kMostBytes);
  const JsonNode root = JsonNode::Parse(text, file);
  root.AllowOnly({"title", "tasks", "time_s", "order", "people"});
  Exam exam;
  exam.sha256 = Sha256(text);
  exam.name = fs::path(file).filename().string();
  exam.name.resize(exam.name.size() - std::string_view(kExamEnding).size());
  if (exam.name.empty() || exam.name.size() > kLongestName ||
      !std::ranges::all_of(exam.name, IsOfName)) {
    throw Error(file +
                ": the file's name is the name of the exam, and may have at most 64 letters, "
                "digits, - _ or .; rename it");
  }
  exam.title = ReadLocalText(root.At("title"));
  exam.time_s = root.At("time_s").Number(1.0, kLongestExam_s);
  const fs::path parent = fs::path(file).parent_path();
  const JsonNode tasks = root.At("tasks");
  const std::vector<JsonNode> nodes = tasks.Items(1);
  if (nodes.size() > kMostTasks) tasks.Fail("has more than 50; split it into two exams");
  for (const JsonNode& node : nodes) {
    exam.tasks.push_back(ReadTask(node, parent.empty() ? "." : parent.string()));
  }
  if (const auto order = root.Find("order")) {
    exam.rotates = order->OneOf({"given", "rotated"}) == "rotated";
  }
  if (const auto people = root.Find("people")) {
    std::vector<NameLook> looks;
    for (const JsonNode& name : people->Items(1)) {
      exam.people.push_back(name.String());
      const NameLook look = LookOf(name.String());
      for (const NameLook& other : looks) {
        if (LookAlike(look, other)) name.Fail("is listed twice; remove one");
      }
      looks.push_back(look);
    }
  }
  return exam;
}

std::vector<std::string> ExamFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (entry.path().string().ends_with(kExamEnding)) files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace palpate
