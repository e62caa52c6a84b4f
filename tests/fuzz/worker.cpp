#include "tests/fuzz/worker.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace palpate::test {
namespace {

/// What a worker has come to: it outlives him.
struct Progress {
  std::size_t number = 0;  ///< of the try that runs
  std::size_t accepted = 0;
  Code code = Code::kOurs;
  char fault[400] = {};
};
Progress* progress = nullptr;

/// assimp loses memory where it throws: a worker's share of it ends with him.
constexpr std::size_t kTriesOfAWorker = 20'000;
/// How often a long run says how far it is, so that one that is ended has told something.
constexpr std::size_t kTold = 20'000;

void Limit() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  prctl(PR_SET_DUMPABLE, 0);  // no core, not by a handler either
  // assimp takes a buffer of a megabyte or more for each file, which the kernel would have to find
  // and clear anew each time.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit gigabyte{std::size_t{1} << 30, std::size_t{1} << 30};
  setrlimit(RLIMIT_AS, &gigabyte);
#endif
}

[[noreturn]] void Work(std::size_t count, const Worker::Run& run) {
  Limit();
  // assimp's assertions fill it; who tries one alone wants to see.
  if (std::getenv("PALPATE_FUZZ_TRY") == nullptr) std::freopen("/dev/null", "w", stderr);
  const std::size_t end = std::min(count, progress->number + kTriesOfAWorker);
  for (; progress->number < end; ++progress->number) {
    const itimerval ten_seconds{{0, 0}, {10, 0}};
    setitimer(ITIMER_PROF, &ten_seconds, nullptr);
    Worker::Enter(Code::kOurs);
    std::string fault;
    progress->accepted += run(progress->number, fault);
    if (fault.empty()) continue;
    std::strncpy(progress->fault, fault.c_str(), sizeof progress->fault - 1);
    _exit(1);
  }
  _exit(0);
}

}  // namespace

void Worker::Enter(Code code) {
  if (progress != nullptr) progress->code = code;
}

Tries Worker::RunAll(std::size_t count, const Run& run) {
  void* const shared =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw std::runtime_error("no memory to share with workers");
  progress = new (shared) Progress;
  Tries tries;
  std::size_t told = 0;
  while (progress->number < count) {
    progress->fault[0] = '\0';
    const pid_t worker = fork();
    if (worker < 0) throw std::runtime_error("no worker can be started");
    if (worker == 0) Work(count, run);
    int status = 0;
    rusage use{};
    while (wait4(worker, &status, 0, &use) < 0 && errno == EINTR) {
    }
    if (progress->number / kTold > told) {
      told = progress->number / kTold;
      std::printf("%zu tries, %zu accepted, %zu deaths of assimp\n", progress->number,
                  progress->accepted, tries.deaths_in_theirs);
      std::fflush(stdout);
    }
    tries.peak_bytes = std::max(tries.peak_bytes, static_cast<std::size_t>(use.ru_maxrss) * 1024);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    const std::string why = progress->fault[0] != '\0' ? progress->fault
                            : WIFSIGNALED(status)
                                ? std::string("died of ") + strsignal(WTERMSIG(status))
                                : "ended with " + std::to_string(WEXITSTATUS(status));
    if (progress->code == Code::kTheirs && progress->fault[0] == '\0') {
      ++tries.deaths_in_theirs;
    } else {
      tries.faults.push_back("try " + std::to_string(progress->number) + ": " + why);
    }
    ++progress->number;
  }
  tries.done = count;
  tries.accepted = progress->accepted;
  munmap(shared, sizeof(Progress));
  progress = nullptr;
  return tries;
}

std::size_t TriesOr(std::size_t briefly) {
  const char* const many = std::getenv("PALPATE_FUZZ_TRIES");
  return many == nullptr ? briefly : std::strtoull(many, nullptr, 10);
}

}  // namespace palpate::test
