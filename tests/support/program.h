#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace palpate::test {

/// Runs a program as a child process and collects its stdout and stderr together.  The program is
/// killed when this object, or the thread that made it, ends.
class Program {
 public:
  /// @param file  its path.  If it cannot be run, the exit status is 127.
  Program(const std::string& file, std::vector<std::string> arguments);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Reads output until `text` appears, starting after the text found by the last call.  False if
  /// the program ends, or `seconds` pass, before that.
  bool Says(const std::string& text, double seconds = 20.0);
  /// Returns all output so far.  Call it now and then, because a full pipe blocks the program.
  const std::string& Output();
  /// Closes this end of its stdout and stderr, as a reader does that has ended.
  void CloseOutput();
  /// Returns true until the program has ended.
  bool Runs();
  void Signal(int signal) const;
  /// Returns true if the program has a handler for the signal by now.
  bool Handles(int signal) const;
  pid_t id() const { return pid_; }
  /// Waits for the end; kills the program after `seconds`.  Returns its exit status, or the
  /// negative signal that ended it.
  int Exit(double seconds = 20.0);

 private:
  /// Waits up to `seconds` for more of its output; false at the end of that.
  bool Read(double seconds);

  pid_t pid_ = -1;
  int output_ = -1;
  int status_ = 0;
  std::string text_;
  std::size_t searched_ = 0;
};

/// Returns the arguments with more appended.
std::vector<std::string> Joined(std::vector<std::string> words,
                                const std::vector<std::string>& more);

/// Returns the folder of this program and of the build's other programs.
std::string OwnFolder();

}  // namespace palpate::test
