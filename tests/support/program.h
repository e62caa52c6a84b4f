#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace palpate::test {

/// A program that runs beside this one, with what it says on stdout and stderr together.  It is
/// killed with this object, and with the thread that made it.
class Program {
 public:
  /// @param file  its path.  A file that cannot be run exits with 127.
  Program(const std::string& file, std::vector<std::string> arguments);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Reads on until it has said `text`, from where the last call that found its text ended.  False
  /// where it ends, or `seconds` pass, before.
  bool Says(const std::string& text, double seconds = 20.0);
  /// All that it has said until now.  To be called now and then: a full pipe stops it.
  const std::string& Output();
  /// True until it has ended.
  bool Runs();
  void Signal(int signal) const;
  pid_t id() const { return pid_; }
  /// Its exit status, or the negative signal that ended it.  Kills it after `seconds`.
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

/// What a program is told, with more behind it.
std::vector<std::string> Joined(std::vector<std::string> words,
                                const std::vector<std::string>& more);

/// The folder that this program stands in, where the others of the build stand too.
std::string OwnFolder();

}  // namespace palpate::test
