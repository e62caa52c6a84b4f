// A process with an ordinary user's rights that may lock 6 MB of memory and uses less.  A separate
// program, linked statically and without sanitizers: a test with its libraries is larger than that,
// and not everybody may raise the limit.  Says what EnterRealtime made of it; exits with 0 if
// memory can still be had, 1 if it cannot, 2 if the case could not be set up.
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
