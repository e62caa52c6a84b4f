#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program.h"

namespace palpate::faults {

/// Something that had to hold, and whether it did.
struct Finding {
  std::string must;   ///< "the station resumes by itself"
  std::string found;  ///< "after 0.4 s"
  bool held = false;
};

/// A laboratory of real programs in a domain and a folder of its own: a server, a station whose
/// simulated hand presses on a cube, a gateway and a recorder.  Each is started on demand, and
/// killed with the laboratory.
class Lab {
 public:
  /// @param transport  udp or shm; shm needs a running RouDi.
  explicit Lab(int domain, std::string transport = "udp");
  ~Lab();
  Lab(const Lab&) = delete;
  Lab& operator=(const Lab&) = delete;

  /// From now on starts the program of that name ("palpate-server") with these words before its
  /// own, as an argument of the program that they name.
  void StartWith(const std::string& program, std::vector<std::string> words) {
    start_with_[program] = std::move(words);
  }

  /// Each throws Error with the program's output if it does not come up.
  /// @param before  words before all others, as of a shell that limits it.
  void StartServer(const std::vector<std::string>& more = {},
                   const std::vector<std::string>& before = {});
  void StartStation(const std::vector<std::string>& more = {});
  void StartGateway();
  void StartRecorder();
  /// A second station, whose only task is to get a session.
  std::unique_ptr<test::Program> AnotherStation(const std::string& id, const std::string& scene);

  std::unique_ptr<test::Program> server, station, gateway, recorder;
  int port() const { return port_; }
  std::string recording() const { return (folder_ / "lab.mcap").string(); }
  std::filesystem::path folder() const { return folder_; }
  int domain() const { return domain_; }

  /// True once the station has more of its poses answered: the loop runs.
  bool Answers(double seconds = 30.0);
  /// Seconds until the station says that its session has resumed; negative: not within 60 s.
  double SecondsUntilResumed();
  /// What the gateway answers to a path with 200; empty: it does not.
  std::string Get(const std::string& path) const;

  /// Ends the station and checks every tick that its hand felt: no change beyond the slew limit,
  /// and no force later than 27 ms into a silence, by the limiter's count.
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

// Checks that several faults share.

void Wait(double seconds);
Finding Lives(const std::string& who, test::Program& program);
Finding LoopRuns(Lab& lab);
Finding Resumes(Lab& lab);
/// The loop does not notice what happens to others.
/// @param said_before  the station's output before it happened.
Finding Undisturbed(Lab& lab, const std::string& said_before);
Finding Says(const std::string& must, test::Program& program, const std::string& text);
Finding EndsInOrder(const std::string& who, test::Program& program);
/// Waits up to 10 s for the gateway to tell of the lab's scene.
Finding Shows(const std::string& must, Lab& lab);

}  // namespace palpate::faults
