#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/course/criteria_file.h"
#include "client/course/local_text.h"
#include "common/json/pose_script.h"

namespace palpate {

/// An exercise for students, read from a file that a teacher edits (exercises/README.md
/// describes every field).
struct Exercise {
  struct Picture {
    std::string file;  ///< path relative to the exercise's folder
    LocalText text;    ///< what it shows
  };
  /// The state in which a cut scene begins a trial.
  enum class Start { kWhole, kBookmark, kAsItIs };

  std::string name;  ///< file name without folder and ending; trials are stored under it
  std::string file;
  LocalText title;
  std::string scene;       ///< a name of the catalogue, or the path of a scene file
  std::string scene_name;  ///< the name under which servers offer it
  std::string tool;
  std::vector<std::string> tools;  ///< it, and if it cuts, all others of the scene that do
  Start start = Start::kWhole;
  LocalText instruction;
  std::vector<Picture> pictures;
  LocalText goal;                      ///< one line
  double most_N = 0.0;                 ///< force limit; 0: none
  double most_s = 0.0;                 ///< time limit
  int trials = 0;                      ///< number of trials that make a grade
  std::string expert;                  ///< the pose script of an expert's hand
  std::vector<PoseScript::Key> guide;  ///< the expert's poses if pages may show them; else empty
  Criteria criteria;
  std::vector<std::string> sources;  ///< publications behind its limits and criteria

  std::string folder() const;
};

inline constexpr const char* kExerciseEnding = ".exercise.json";

/// Reads an exercise and checks all of it: its fields, that scene, tool, pictures and script
/// exist, and that the scene provides what the criteria measure.  Throws Error "file:line: field:
/// what is wrong; remedy".
Exercise LoadExercise(const std::string& file);

/// Reads the criteria of an exercise, or of a file of criteria alone.  Throws Error as
/// LoadExercise.
Criteria LoadCriteria(const std::string& file);

/// Returns the exercises of a folder by name; none if the folder does not exist.
/// @param refused  told of each invalid file, which is left out.
std::vector<Exercise> LoadExercises(const std::string& folder,
                                    const std::function<void(const std::string&)>& refused);

}  // namespace palpate
