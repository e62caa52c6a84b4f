#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace palpate {

/// A program that runs as a child, with its input and all that it says at pipes.  Ends where this
/// process does, also where that is killed.  Thread contract: one thread.  Nothing here blocks, but
/// for the destructor: it kills.
class ChildProgram {
 public:
  /// @param program    its path.   @param arguments  without its name.
  /// @param what       it is, for complaints.   @param on_line  told each line that it says.
  /// Throws Error where no process can be made.
  ChildProgram(const std::string& program, const std::vector<std::string>& arguments,
               std::string what, std::function<void(const std::string&)> on_line = nullptr);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// Shorter than PIPE_BUF: a line is written whole, or, where the child is too busy to read, not.
  void Write(std::string_view line);
  void CloseInput();
  void Signal(int signal);

  /// Looks after it.  False once it has ended.
  bool Poll();
  /// Once it has ended: what it complained of last; empty where it ended in order.
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
