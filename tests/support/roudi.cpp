#include "tests/support/roudi.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/dds/participant.h"
#include "common/error.h"
#include "common/files/project_files.h"

namespace palpate {
namespace {

constexpr const char* kLock = "/tmp/palpate-roudi-tests.lock";

/// Waits up to 10 s.
bool Eventually(bool (*condition)()) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

// $1: pool file.  Prints iox-roudi's process id, then waits for the end of its input.  RouDi 2.0.3
// can wait for ever for a client that dies meanwhile, hence the kill.  Descriptor 9 is the lock.
constexpr const char* kGuardian = R"(
exec 3>&1 1>/dev/null 2>&1
iox-roudi -c "$1" &
roudi=$!
echo $roudi >&3
exec 3>&-
read -r end
kill -TERM $roudi
(sleep 3; kill -KILL $roudi) 9>&- &
killer=$!
wait $roudi
kill $killer
)";

}  // namespace

RouDi::RouDi() {
  const int lock = open(kLock, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock < 0 || flock(lock, LOCK_EX) != 0) throw Error(std::string(kLock) + ": cannot lock");
  if (!Eventually([] { return dds::WhyNoRouDi().has_value(); })) {
    throw Error("another iox-roudi runs on this machine; stop it first");
  }
  int to_guardian[2];
  int from_guardian[2];
  if (pipe(to_guardian) != 0 || pipe(from_guardian) != 0) throw Error("no pipe");
  fcntl(to_guardian[1], F_SETFD, FD_CLOEXEC);
  const std::string pools = PlaceOf(ProjectFile::kSharedMemory);
  if (fork() == 0) {
    dup2(to_guardian[0], STDIN_FILENO);
    dup2(from_guardian[1], STDOUT_FILENO);
    close(to_guardian[0]);
    close(from_guardian[0]);
    close(from_guardian[1]);
    dup2(lock, 9);
    setsid();  // a Ctrl-C at the test must not end RouDi before its clients
    execlp("sh", "sh", "-c", kGuardian, "sh", pools.c_str(), nullptr);
    _exit(127);
  }
  // The guardian holds the lock from now on, until RouDi has ended.
  close(lock);
  close(to_guardian[0]);
  close(from_guardian[1]);
  char text[32] = {};
  if (read(from_guardian[0], text, sizeof text - 1) > 0) pid_ = std::stoi(text);
  close(from_guardian[0]);
  if (!Eventually([] { return !dds::WhyNoRouDi(); })) {
    throw Error("iox-roudi does not come up; is the package 'iceoryx' installed?");
  }
}

void RouDi::Kill() {
  kill(pid_, SIGKILL);
  Eventually([] { return dds::WhyNoRouDi().has_value(); });
}

void RouDi::Hang() {
  kill(pid_, SIGSTOP);
}

bool RouDi::AnotherRuns() {
  const int lock = open(kLock, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock < 0 || flock(lock, LOCK_EX) != 0) throw Error(std::string(kLock) + ": cannot lock");
  const bool answers = !dds::WhyNoRouDi();
  close(lock);
  return answers;
}

}  // namespace palpate
