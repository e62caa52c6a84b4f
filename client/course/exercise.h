#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "client/course/criteria_file.h"
#include "common/json/pose_script.h"

namespace palpate {

/// What people read, by language ("en", "de", "zh"); what a file has as a mere string is English.
using LocalText = std::map<std::string, std::string>;

LocalText ReadLocalText(const JsonNode& node);

/// What a student is given to do: a file that a teacher edits (exercises/README.md has every
/// field).
struct Exercise {
  struct Picture {
    std::string file;  ///< beside the exercise, by that folder
    LocalText text;    ///< what it shows
  };
  /// How the scene stands as a trial begins, where it is one that is cut.
  enum class Start { kWhole, kBookmark, kAsItIs };

  std::string name;  ///< of its file, without folder and ending: by which trials are kept
  std::string file;
  LocalText title;
  std::string scene;       ///< a name of the catalogue, or the path of a scene file
  std::string scene_name;  ///< by which servers serve it
  std::string tool;
  Start start = Start::kWhole;
  LocalText instruction;
  std::vector<Picture> pictures;
  LocalText goal;                      ///< in a line
  double most_N = 0.0;                 ///< limit of force; 0: none
  double most_s = 0.0;                 ///< limit of time
  int trials = 0;                      ///< how many make a grade
  std::string expert;                  ///< the script of a hand that does it as it should be done
  std::vector<PoseScript::Key> guide;  ///< of that, where pages may show it; else empty
  Criteria criteria;
  std::vector<std::string> sources;  ///< of its limits and criteria: publications

  std::string folder() const;
};

inline constexpr const char* kExerciseEnding = ".exercise.json";

/// Reads an exercise and checks all of it: its fields, that scene, tool, pictures and script are
/// there, and that the scene has what the criteria measure.  Throws Error "file:line: field: what
/// is wrong; remedy".
Exercise LoadExercise(const std::string& file);

/// The exercises of a folder by their names; none where there is no such folder.
/// @param refused  told of each file that is none, which is then left out.
std::vector<Exercise> LoadExercises(const std::string& folder,
                                    const std::function<void(const std::string&)>& refused);

}  // namespace palpate
