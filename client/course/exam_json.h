#pragma once

#include <nlohmann/json.hpp>

#include "client/course/exam.h"

namespace palpate {

/// A task as the course's file and the roll store it.
inline void to_json(nlohmann::json& json, const ExamTask& task) {
  json = {{"exercise", task.exercise},
          {"time_s", task.time_s},
          {"trials", task.trials},
          {"exercise_sha256", task.exercise_sha256},
          {"criteria_sha256", task.criteria_sha256},
          {"expert_sha256", task.expert_sha256}};
}

inline void from_json(const nlohmann::json& json, ExamTask& task) {
  task.exercise = json.at("exercise");
  task.time_s = json.at("time_s");
  task.trials = json.at("trials");
  task.exercise_sha256 = json.at("exercise_sha256");
  task.criteria_sha256 = json.at("criteria_sha256");
  task.expert_sha256 = json.value("expert_sha256", "");  // an earlier version stored none
}

}  // namespace palpate
