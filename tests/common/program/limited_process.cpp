// A process with an ordinary user's rights that may lock 6 MB of memory, and has less: a program of
// its own, linked statically and without sanitizers, for a test with its libraries is larger than
// that, and larger limits are not everybody's to set.  Says what EnterRealtime made of it; exits
// with 0 where memory can still be had, 1 where it cannot, 2 where the case could not be made.
#include <cstdio>

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/program/realtime.h"

int main() {
  const rlimit limit{6 << 20, 6 << 20};
  if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0) return 2;
  if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) return 2;
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return 2;
  munlockall();
  std::puts(palpate::EnterRealtime({}).summary.c_str());
  return mmap(nullptr, 64 << 20, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED;
}
