#pragma once

namespace palpate {

/// RouDi with the project's pools, for one test.  Only one can run on a machine, so other tests
/// wait for a lock file meanwhile.
///
/// It ends only after this process: when RouDi stops, it sends SIGTERM to every remaining client,
/// and a process that has used shared memory is a client until its exit.  So a guardian process
/// runs RouDi, and stops it once the pipe from this process closes.
class RouDi {
 public:
  /// Throws Error if iox-roudi does not start.
  RouDi();
  RouDi(const RouDi&) = delete;
  RouDi& operator=(const RouDi&) = delete;

  /// Returns true if another RouDi runs; first waits for the end of those that this class started.
  static bool AnotherRuns();

  /// Kills RouDi like a crash: its socket stays behind.
  void Kill();
  /// Stops RouDi from answering, like one that waits for a lock that a dead process holds.
  void Hang();

 private:
  int pid_ = -1;
};

}  // namespace palpate
