#pragma once

namespace palpate {

/// RouDi with the project's pools, for one test.  Only one can run on a machine, so a lock file
/// keeps others' tests waiting meanwhile.
///
/// It ends when this process has: RouDi sends SIGTERM to every client that is left when it stops,
/// and a process that has used shared memory is a client until its exit.  Hence a guardian process
/// runs it, and stops it once the pipe from this process closes.
class RouDi {
 public:
  /// Throws Error where iox-roudi does not come up.
  RouDi();
  RouDi(const RouDi&) = delete;
  RouDi& operator=(const RouDi&) = delete;

  /// True where one runs that this class did not start; waits until those that it did have ended.
  static bool AnotherRuns();

  /// Kills it as a crash would: its socket stays behind.
  void Kill();
  /// From now on it answers nobody, as one that waits for a lock that a dead process holds.
  void Hang();

 private:
  int pid_ = -1;
};

}  // namespace palpate
