#pragma once

#include <string>

namespace palpate {

/// The right to keep a course's trials, FOLDER/gateway.lock: one process a folder has it, because
/// each marks what is left of running trials when it starts.  The system takes it back when the
/// process ends, also by kill -9; programs that it started do not inherit it.
/// Thread contract: one thread.
class CourseLock {
 public:
  static constexpr const char* kFile = "gateway.lock";

  /// Throws Error, which names the folder, the process that has it and its address, and the remedy.
  /// @param folder  must exist.
  explicit CourseLock(const std::string& folder);
  ~CourseLock();
  CourseLock(const CourseLock&) = delete;
  CourseLock& operator=(const CourseLock&) = delete;

  /// Tells those who are refused where this process serves the course.
  void Tell(const std::string& address) const;

 private:
  int fd_ = -1;
};

}  // namespace palpate
