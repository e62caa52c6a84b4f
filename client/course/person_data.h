#pragma once

#include <cstdint>
#include <string>

#include "client/course/course_file.h"
#include "client/course/roster.h"

namespace palpate {

/// What a course has of a person, given to them and deleted.
/// Thread contract: as CourseFile.

/// A ZIP of all of it, whose files are stored as they are: recordings, score pages, and besides
/// them what is given here.
/// @param folder  of the course.   @param csv  of the person's trials.
/// Returns a file that is open for reading, from its beginning, and has no name: it goes with its
/// last descriptor, and with the process.  Throws Error.
int GiveData(const std::string& folder, const Person& person, const std::string& csv);

/// Deletes a person from every table of the course that has a column `person`, then the recordings
/// and score pages.  Nothing of them stays but that their number is never another's; SQLite
/// overwrites what it deletes.  Killed in the middle, nobody is listed of whom a part is gone:
/// FinishDeletions removes the rest.  Throws Error; where files cannot be removed, with where they
/// are.
void DeletePerson(CourseFile& file, const std::string& folder, std::int64_t person);
/// What a killed process has left to be removed; the log has what cannot be.  Throws Error where
/// the course's file cannot be used.
void FinishDeletions(CourseFile& file, const std::string& folder);

}  // namespace palpate
