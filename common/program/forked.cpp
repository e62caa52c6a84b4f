#include "common/program/forked.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::int64_t kFarewell_ns = 3'000'000'000;
// The first character of each line to the parent.
constexpr char kLine = '+', kCrashed = '!', kFinished = '.';

int to_parent = -1;

/// Runs in the thread that crashed, so it calls only async-signal-safe functions.
void OnCrash(int signal) {
  const char* const name = foreign_call != nullptr ? foreign_call : "";
  (void)!write(to_parent, &kCrashed, 1);
  (void)!write(to_parent, name, std::strlen(name));
  (void)!write(to_parent, "\n", 1);
  raise(signal);  // now with the default action
}

[[noreturn]] void Child(
    int pipe, const std::function<void(const std::function<void(const std::string&)>&)>& work) {
  setpgid(0, 0);  // with all that the work starts
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  to_parent = pipe;
  struct sigaction action {};
  action.sa_handler = OnCrash;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS}) {
    sigaction(signal, &action, nullptr);
  }
  const auto say = [pipe](const std::string& line) {
    (void)!write(pipe, (line + "\n").data(), line.size() + 1);
  };
  try {
    work([&](const std::string& line) { say(kLine + line); });
    say({kFinished});
  } catch (...) {  // not finished
  }
  std::fflush(nullptr);
  _exit(0);
}

/// Takes the whole lines of what has come.
void Take(std::string& text, ForkedEnd& end, std::string& crashed_in) {
  for (std::size_t at; (at = text.find('\n')) != std::string::npos; text.erase(0, at + 1)) {
    const std::string line = text.substr(1, at - 1);
    if (text[0] == kLine) end.lines.push_back(line);
    if (text[0] == kFinished) end.finished = true;
    if (text[0] == kCrashed) crashed_in = line.empty() ? "a thread of its own" : line;
  }
}

std::string HowItEnded(int status, bool told_to_end, bool late, const std::string& crashed_in) {
  if (told_to_end) return "had not returned when this program was told to end";
  if (late) return "did not return in time";
  const std::string who = crashed_in.empty() ? "" : crashed_in + " ";
  if (WIFSIGNALED(status)) {
    return who + "crashed (" + std::string(strsignal(WTERMSIG(status))) + ")";
  }
  return "ended the process (exit status " + std::to_string(WEXITSTATUS(status)) + ")";
}

}  // namespace

ForkedEnd RunForked(
    const std::function<void(const std::function<void(const std::string&)>& tell)>& work,
    double seconds, const std::function<bool()>& stopped) {
  int ends[2] = {-1, -1};
  std::fflush(nullptr);  // so that the copy does not print it again
  const pid_t child = pipe2(ends, O_CLOEXEC) == 0 ? fork() : -1;
  if (child == 0) Child(ends[1], work);
  const int error = errno;
  if (ends[1] >= 0) close(ends[1]);
  if (child < 0) {
    if (ends[0] >= 0) close(ends[0]);
    throw Error("cannot make a process (" + std::string(std::strerror(error)) +
                "); end other programs, or raise 'ulimit -u'");
  }
  setpgid(child, child);  // whoever is first
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  ForkedEnd end;
  std::string text, crashed_in;
  std::int64_t until_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
  bool told_to_end = false, late = false;
  int status = 0;
  for (bool runs = true; runs;) {
    pollfd more{ends[0], POLLIN, 0};
    poll(&more, 1, 10);
    if ((more.revents & POLLHUP) != 0) usleep(1000);  // it has closed the pipe and not yet ended
    runs = waitpid(child, &status, WNOHANG) == 0;
    char buffer[4096];
    for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
      text.append(buffer, static_cast<std::size_t>(n));
    }
    Take(text, end, crashed_in);
    if (runs && !told_to_end && stopped()) {
      told_to_end = true;
      kill(child, SIGTERM);
      until_ns = SteadyNanoseconds() + kFarewell_ns;
    }
    if (runs && SteadyNanoseconds() > until_ns) {
      late = true;
      kill(child, SIGKILL);
    }
  }
  close(ends[0]);
  kill(-child, SIGKILL);  // what it has started: that would keep our output open for ever
  if (!end.finished) end.how = HowItEnded(status, told_to_end, late, crashed_in);
  return end;
}

}  // namespace palpate
