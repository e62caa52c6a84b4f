#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace palpate {

/// Runs a program as a child process, with pipes at its input and output.  The child ends with this
/// process, even if that is killed.  Thread contract: one thread.  Nothing here blocks except the
/// destructor, which kills the child.
class ChildProgram {
 public:
  /// @param program    its path.
  /// @param arguments  without the program's name.
  /// @param what       what the program is, for complaints.
  /// @param on_line  called with each line of its output.
  /// Throws Error if the process cannot be created.
  ChildProgram(const std::string& program, const std::vector<std::string>& arguments,
               std::string what, std::function<void(const std::string&)> on_line = nullptr);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// Writes a line to the child, whole or, if the child is too busy to read, not at all.  The line
  /// must be shorter than PIPE_BUF.
  void Write(std::string_view line);
  void CloseInput();
  void Signal(int signal);

  /// Reads the child's output and checks its state.  Returns false once it has ended.
  bool Poll();
  /// After the end: the child's last complaint; empty if it ended normally.
  const std::string& complaint() const { return complaint_; }

 private:
  void ReadOutput();

  const std::string name_;  // of the program
  const std::string what_;
  std::function<void(const std::string&)> on_line_;
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
  std::string last_line_;
  std::string line_;
  std::string complaint_;
};

}  // namespace palpate
