#include "client/replayer/export/export_folder.h"

#include <system_error>

#include "common/error.h"

namespace palpate {

namespace fs = std::filesystem;

ExportFolder::ExportFolder(const std::string& folder) : name_(folder) {
  const bool is_free = !fs::exists(fs::symlink_status(name_)) ||
                       (fs::is_directory(fs::symlink_status(name_)) && fs::is_empty(name_));
  if (!is_free) {
    throw Error("-o " + folder + ": exists already; give another name, or remove it first");
  }
  while (name_.has_relative_path() && !name_.has_filename()) name_ = name_.parent_path();
  part_ = name_;
  part_ += ".part";
  std::error_code problem;
  if (name_.has_parent_path()) fs::create_directories(name_.parent_path(), problem);
  if (!fs::create_directory(part_, problem)) {
    throw Error(part_.string() +
                (problem ? ": cannot be made (" + problem.message() + "); give another folder"
                         : ": exists already, from an export that is running or was killed; remove "
                           "it, or give another name"));
  }
}

ExportFolder::~ExportFolder() {
  std::error_code ignored;
  if (!is_whole_) fs::remove_all(part_, ignored);
}

void ExportFolder::Finish() {
  is_whole_ = true;
  std::error_code problem;
  fs::rename(part_, name_, problem);  // replaces only an empty folder
  if (problem) {
    throw Error("-o " + name_.string() + ": another program has created it meanwhile (" +
                problem.message() + "); the complete export is in " + part_.string() +
                ": move one of the two");
  }
}

}  // namespace palpate
