#pragma once

#include <cstdint>
#include <string>

#include "client/course/course_file.h"
#include "client/course/roster.h"

namespace palpate {

/// Hands out and deletes what a course stores about a person.
/// Thread contract: as CourseFile.

/// Room for a trial of some 16 MB of each of 16 people.
constexpr std::uintmax_t kLeftFree = std::uintmax_t{256} << 20;

/// Writes a person's data into a ZIP without compression: recordings and score pages, and besides
/// them the CSV.
/// @param folder  of the course.   @param csv  of the person's trials.
/// @param left_free  bytes that it leaves free on the course's disk, for recordings.
/// Returns a descriptor, at the file's beginning, of an unlinked file, which vanishes when its last
/// descriptor is closed or the process ends.  Throws Error.
int GiveData(const std::string& folder, const Person& person, const std::string& csv,
             std::uintmax_t left_free = kLeftFree);

/// Deletes a person from every table of the course that has a column `person`, then removes the
/// recordings and score pages.  Only the number stays, so that nobody else gets it; SQLite
/// overwrites what it deletes.  If the process is killed in between, the person is no longer
/// listed and FinishDeletions removes the rest.  Throws Error; if files cannot be removed, it says
/// where they are.
void DeletePerson(CourseFile& file, const std::string& folder, std::int64_t person);
/// Removes what an interrupted deletion left; files that cannot be removed are logged.  Throws
/// Error if the course's file cannot be used.
void FinishDeletions(CourseFile& file, const std::string& folder);

}  // namespace palpate
