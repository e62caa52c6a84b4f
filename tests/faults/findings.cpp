#include "tests/faults/findings.h"

#include <chrono>
#include <csignal>
#include <thread>

#include <spdlog/fmt/fmt.h>

namespace palpate::faults {

void Wait(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

Finding Lives(const std::string& who, test::Program& program) {
  const bool runs = program.Runs();
  return {who + " lives", runs ? "yes" : "ended:\n" + program.Output(), runs};
}
Finding LoopRuns(Lab& lab) {
  const bool runs = lab.Answers();
  return {"the station's poses are answered", runs ? "yes" : lab.station->Output(), runs};
}
Finding Resumes(Lab& lab) {
  const double seconds = lab.SecondsUntilResumed();
  return {
      "the station resumes untouched once the server is ready (goal 3 s)",
      seconds < 0.0 ? "not within 60 s:\n" + lab.station->Output() : "after " + Seconds(seconds),
      seconds >= 0.0};
}
/// What happened to others is nothing to the loop.
Finding Undisturbed(Lab& lab, const std::string& said_before) {
  const std::string said = lab.station->Output().substr(said_before.size());
  const bool disturbed = said.find("asking") != std::string::npos ||
                         said.find("no replies") != std::string::npos || !lab.station->Runs();
  return {"the loop goes on", disturbed ? said : "no session was lost", !disturbed};
}
Finding Says(const std::string& must, test::Program& program, const std::string& text) {
  const bool says = program.Says(text, 30.0);
  return {must, says ? "'" + text + "'" : program.Output(), says};
}
Finding EndsInOrder(const std::string& who, test::Program& program) {
  program.Signal(SIGTERM);
  const int exit = program.Exit(30.0);
  return {who + " ends cleanly", fmt::format("exit status {}", exit), exit == 0};
}

Finding Shows(const std::string& must, Lab& lab) {
  Finding shows{must, "", false};
  for (int i = 0; i < 100 && !shows.held; ++i) {
    shows.held = lab.Get("/healthz").find("\"cube\"") != std::string::npos;
    if (!shows.held) Wait(0.1);
  }
  shows.found = shows.held ? "it does" : lab.gateway->Output();
  return shows;
}

}  // namespace palpate::faults
