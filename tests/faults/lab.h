#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program.h"

namespace palpate::faults {

/// What one fault had to leave true, and whether it did.
struct Finding {
  std::string must;   ///< "the station resumes by itself"
  std::string found;  ///< "after 0.4 s"
  bool held = false;
};

/// A laboratory of real programs in a domain and a folder of its own: a server, a station whose
/// simulated hand presses on a cube, a gateway and a recorder.  Each is started when it is asked
/// for, and killed with the laboratory.
class Lab {
 public:
  /// @param transport  udp, or shm (then a RouDi must run).
  explicit Lab(int domain, std::string transport = "udp");
  ~Lab();
  Lab(const Lab&) = delete;
  Lab& operator=(const Lab&) = delete;

  /// From now on a program of that name ("palpate-server") starts with these words before its own,
  /// as of another program that runs it.
  void StartWith(const std::string& program, std::vector<std::string> words) {
    start_with_[program] = std::move(words);
  }

  /// Each throws Error, with what the program said, where it does not come up.
  /// @param before  words before all others, as of a shell that limits it.
  void StartServer(const std::vector<std::string>& more = {},
                   const std::vector<std::string>& before = {});
  void StartStation(const std::vector<std::string>& more = {});
  void StartGateway();
  void StartRecorder();
  /// A second station, of which nothing is asked but that it has a session.
  std::unique_ptr<test::Program> AnotherStation(const std::string& id, const std::string& scene);

  std::unique_ptr<test::Program> server, station, gateway, recorder;
  int port() const { return port_; }
  std::string recording() const { return (folder_ / "lab.mcap").string(); }
  std::filesystem::path folder() const { return folder_; }
  int domain() const { return domain_; }

  /// True once the station has more than that of its poses answered: the loop runs.
  bool Answers(double seconds = 30.0);
  /// Seconds until the station says that its session has resumed; negative: it does not in 60 s.
  double SecondsUntilResumed();
  /// What of a path the gateway answers with 200; empty: nothing.
  std::string Get(const std::string& path) const;

  /// Ends the station and looks at every tick that its hand has felt: no change beyond the slew
  /// limit, no force later than 27 ms of silence by the limiter's count.
  Finding JudgeTheHand();

 private:
  std::unique_ptr<test::Program> Run(const std::string& name, std::vector<std::string> arguments,
                                     const std::vector<std::string>& before = {}) const;

  int domain_;
  std::string transport_;
  std::filesystem::path folder_;
  int port_ = 0;
  std::map<std::string, std::vector<std::string>> start_with_;  // by program
};

/// "0.42 s"
std::string Seconds(double seconds);

using Findings = std::vector<Finding>;

// What several faults look at.

void Wait(double seconds);
Finding Lives(const std::string& who, test::Program& program);
Finding LoopRuns(Lab& lab);
Finding Resumes(Lab& lab);
/// What happened to others is nothing to the loop.
/// @param said_before  what the station had said until then.
Finding Undisturbed(Lab& lab, const std::string& said_before);
Finding Says(const std::string& must, test::Program& program, const std::string& text);
Finding EndsInOrder(const std::string& who, test::Program& program);
/// Waits up to 10 s for the gateway to tell of the lab's scene.
Finding Shows(const std::string& must, Lab& lab);

}  // namespace palpate::faults
