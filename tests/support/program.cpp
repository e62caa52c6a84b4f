#include "tests/support/program.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate::test {
namespace {

std::int64_t After(double seconds) {
  return SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
}
double SecondsUntil(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns - SteadyNanoseconds());
}

}  // namespace

Program::Program(const std::string& file, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), file);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Error("no pipe to " + file);
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    execv(file.c_str(), argv.data());
    _exit(127);
  }
  close(ends[1]);
  output_ = ends[0];
}

Program::~Program() {
  Exit(0.0);
  close(output_);
}

bool Program::Read(double seconds) {
  pollfd wait{output_, POLLIN, 0};
  if (poll(&wait, 1, static_cast<int>(1e3 * std::max(0.0, seconds))) != 1) return false;
  char buffer[4096];
  const ssize_t n = read(output_, buffer, sizeof buffer);
  if (n > 0) text_.append(buffer, static_cast<std::size_t>(n));
  return n > 0;
}

bool Program::Says(const std::string& text, double seconds) {
  const std::int64_t end = After(seconds);
  for (;;) {
    const std::size_t found = text_.find(text, searched_);
    if (found != std::string::npos) {
      searched_ = found + text.size();
      return true;
    }
    if (!Read(SecondsUntil(end))) return false;
  }
}

const std::string& Program::Output() {
  while (Read(0.0)) {
  }
  return text_;
}

void Program::CloseOutput() {
  close(output_);
  output_ = -1;
}

bool Program::Handles(int signal) const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("SigCgt:")) continue;
    return std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1;
  }
  return false;
}

bool Program::Runs() {
  if (pid_ > 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
  return pid_ > 0;
}

void Program::Signal(int signal) const {
  if (pid_ > 0) kill(pid_, signal);
}

int Program::Exit(double seconds) {
  const std::int64_t end = After(seconds);
  while (Runs()) {
    if (SecondsUntil(end) <= 0.0) Signal(SIGKILL);
    // It may have closed its output and not yet ended.
    if (!Read(0.01)) usleep(1000);
  }
  Output();
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
}

std::vector<std::string> Joined(std::vector<std::string> words,
                                const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string OwnFolder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().string();
}

}  // namespace palpate::test
