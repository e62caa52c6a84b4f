#include "client/viewer/mouse_station.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

constexpr std::int64_t kPatience_ns = 3'000'000'000;
constexpr std::size_t kLongestLine = 1000;

void Close(int& file) {
  if (file >= 0) close(file);
  file = -1;
}

/// In the child, after fork: only what POSIX calls async-signal-safe.
[[noreturn]] void BecomeStation(char* const* argv, int input, int output) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  setsid();  // Ctrl-C at the gateway's terminal is the gateway's to handle
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  close_range(3, ~0u, 0);  // sockets of viewers, which would outlive them
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGPIPE, SIG_DFL);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

std::string ToMouseLine(const Pose& X) {
  std::string line;
  for (const double value : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) {
    char text[32];
    const char* end = std::to_chars(text, text + sizeof text, value).ptr;
    if (!line.empty()) line += ' ';
    line.append(static_cast<const char*>(text), end);
  }
  return line + '\n';
}

MouseStation::MouseStation(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  int in[2] = {-1, -1};
  int out[2] = {-1, -1};
  if (pipe2(in, O_CLOEXEC) == 0 && pipe2(out, O_CLOEXEC) == 0) pid_ = fork();
  if (pid_ == 0) BecomeStation(argv.data(), in[0], out[1]);
  const int error = errno;
  Close(in[0]);
  Close(out[1]);
  input_ = in[1];
  output_ = out[0];
  if (pid_ < 0) {
    Close(input_);
    Close(output_);
    throw Error("no process for a mouse (" + std::string(std::strerror(error)) +
                "): are too many running?");
  }
  fcntl(input_, F_SETFL, O_NONBLOCK);
  fcntl(output_, F_SETFL, O_NONBLOCK);
}

MouseStation::~MouseStation() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Close(input_);
  Close(output_);
}

void MouseStation::Drag(const Pose& X_WT) {
  if (input_ < 0) return;
  const std::string line = ToMouseLine(X_WT);  // shorter than PIPE_BUF: written whole or not at all
  if (write(input_, line.data(), line.size()) < 0 && errno != EAGAIN) Close(input_);
}

void MouseStation::LetGo(std::int64_t now_ns) {
  if (let_go_ns_ == 0) let_go_ns_ = now_ns;
  Close(input_);
}

void MouseStation::ReadOutput() {
  char buffer[4096];
  for (ssize_t n; (n = read(output_, buffer, sizeof buffer)) > 0;) {
    for (const char c : std::string_view(buffer, static_cast<std::size_t>(n))) {
      if (c != '\n') {
        if (line_.size() < kLongestLine) line_ += c;
        continue;
      }
      spdlog::debug("mouse: {}", line_);
      if (!line_.empty()) last_line_ = std::move(line_);
      line_.clear();
    }
  }
}

bool MouseStation::Poll(std::int64_t now_ns) {
  if (pid_ < 0) return false;
  int status = 0;
  const pid_t found = waitpid(pid_, &status, WNOHANG);
  // Somebody else has waited for it: it has ended, and its number may be another process's by now.
  const bool taken = found < 0 && errno == ECHILD;
  ReadOutput();
  if (found != pid_ && !taken) {
    if (let_go_ns_ != 0 && now_ns - let_go_ns_ > kPatience_ns) kill(pid_, SIGKILL);
    return true;
  }
  pid_ = -1;
  if (taken) {
    complaint_ = "what became of the mouse's station is not known";
    return false;
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return false;
  constexpr std::string_view kName = "palpate-station: ";
  complaint_ = last_line_.starts_with(kName) ? last_line_.substr(kName.size()) : last_line_;
  if (complaint_.empty()) {
    complaint_ = WIFSIGNALED(status) ? "the mouse's station was killed"
                                     : "palpate-station could not be run (exit " +
                                           std::to_string(WEXITSTATUS(status)) + ")";
  }
  return false;
}

}  // namespace palpate
