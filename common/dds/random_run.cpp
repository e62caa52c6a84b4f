#include "common/dds/random_run.h"

#include <random>

namespace palpate {

std::uint64_t RandomRun() {
  std::random_device random;
  const std::uint64_t run = std::uint64_t{random()} << 32 | random();
  return run != 0 ? run : 1;
}

}  // namespace palpate
