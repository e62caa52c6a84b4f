#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/course/exercise.h"
#include "client/course/trial_table.h"

namespace palpate {

/// The exercises of a course, and what web pages are told of them: descriptions, pictures, a
/// person's trials so far, and the keys by which score pages are opened.
/// Thread contract: one thread.
class ExercisePages {
 public:
  /// Reads the exercises of the course's folder, and those shipped with the programs.
  ExercisePages(std::string folder, const TrialTable& trials);

  const std::vector<Exercise>& exercises() const { return exercises_; }
  const Exercise* Find(const std::string& exercise) const;
  /// Returns the folder of a person's trials of an exercise.
  std::string FolderOf(std::int64_t person, const std::string& exercise) const;

  /// Returns the exercises, each with the person's trials so far, for the person's page.
  /// @param teaches  each also with the scene that palpate-server is to be told.
  std::string ListJson(std::int64_t person, bool teaches = false);
  /// Describes one exercise, without hints.  @param exercise  must exist.
  std::string DescribeJson(const std::string& exercise) const;
  /// Returns the path of an exercise's picture, given as "EXERCISE/FILE"; empty: there is none.
  std::string PictureOf(const std::string& path) const;

  /// Returns the key of a trial's score page, which is made at first use.
  std::string KeyOf(const TrialKey& trial);
  /// Returns the keys of a person's existing score pages, by exercise and trial number.
  std::map<std::pair<std::string, int>, std::string> PagesOf(std::int64_t person);
  /// Returns the path of the score page with that key; empty: there is none.
  std::string PageOf(const std::string& key) const;
  /// Invalidates the keys of these people's score pages.  A later request creates new keys.
  void Forget(const std::set<std::int64_t>& people);

 private:
  std::string PageFileOf(const TrialKey& trial) const;
  bool HasPage(const TrialRow& row) const;

  const std::string folder_;
  const TrialTable& trials_;
  std::vector<Exercise> exercises_;
  std::map<std::string, std::string> pages_;  // files, by key
};

}  // namespace palpate
