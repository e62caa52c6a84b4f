#include "common/program/child_program.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestLine = 1000;

void Close(int& file) {
  if (file >= 0) close(file);
  file = -1;
}

/// Runs in the child after fork, so it only calls async-signal-safe functions.
[[noreturn]] void Become(char* const* argv, int input, int output) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  setsid();  // Ctrl-C at a terminal is the parent's to handle
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  close_range(3, ~0u, 0);  // closes files and sockets, which would otherwise outlive their owner
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGPIPE, SIG_DFL);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

ChildProgram::ChildProgram(const std::string& program, const std::vector<std::string>& arguments,
                           std::string what, std::function<void(const std::string&)> on_line)
    : name_(std::filesystem::path(program).filename().string()),
      what_(std::move(what)),
      on_line_(std::move(on_line)) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  int in[2] = {-1, -1};
  int out[2] = {-1, -1};
  if (pipe2(in, O_CLOEXEC) == 0 && pipe2(out, O_CLOEXEC) == 0) pid_ = fork();
  if (pid_ == 0) Become(argv.data(), in[0], out[1]);
  const int error = errno;
  Close(in[0]);
  Close(out[1]);
  input_ = in[1];
  output_ = out[0];
  if (pid_ < 0) {
    Close(input_);
    Close(output_);
    throw Error("cannot start " + what_ + " (" + std::string(std::strerror(error)) +
                "); end other programs, or raise 'ulimit -u'");
  }
  fcntl(input_, F_SETFL, O_NONBLOCK);
  fcntl(output_, F_SETFL, O_NONBLOCK);
}

ChildProgram::~ChildProgram() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Close(input_);
  Close(output_);
}

void ChildProgram::Write(std::string_view line) {
  if (input_ < 0) return;
  if (write(input_, line.data(), line.size()) < 0 && errno != EAGAIN) Close(input_);
}

void ChildProgram::CloseInput() {
  Close(input_);
}

void ChildProgram::Signal(int signal) {
  if (pid_ > 0) kill(pid_, signal);
}

void ChildProgram::ReadOutput() {
  char buffer[4096];
  for (ssize_t n; (n = read(output_, buffer, sizeof buffer)) > 0;) {
    for (const char c : std::string_view(buffer, static_cast<std::size_t>(n))) {
      if (c != '\n') {
        if (line_.size() < kLongestLine) line_ += c;
        continue;
      }
      if (on_line_) on_line_(line_);
      if (!line_.empty()) last_line_ = std::move(line_);
      line_.clear();
    }
  }
}

bool ChildProgram::Poll() {
  if (pid_ < 0) return false;
  int status = 0;
  const pid_t found = waitpid(pid_, &status, WNOHANG);
  // The child has ended and was waited for elsewhere; its pid may belong to another process by now.
  const bool taken = found < 0 && errno == ECHILD;
  ReadOutput();
  if (found != pid_ && !taken) return true;
  pid_ = -1;
  if (taken) {
    complaint_ = "what became of " + what_ + " is not known";
    return false;
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return false;
  const std::string named = name_ + ": ";
  complaint_ = last_line_.starts_with(named) ? last_line_.substr(named.size()) : last_line_;
  if (WIFSIGNALED(status)) {
    complaint_ = what_ + " was killed";
  } else if (complaint_.empty()) {
    complaint_ = name_ + " could not be run (exit " + std::to_string(WEXITSTATUS(status)) + ")";
  }
  return false;
}

}  // namespace palpate
