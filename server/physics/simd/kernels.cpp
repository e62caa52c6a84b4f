#include "server/physics/simd/kernels.h"

#include <atomic>
#include <cstdlib>
#include <cstring>

namespace palpate {
namespace {

const Kernels* Choose() {
  const Kernels* available[3];
  const int count = AvailableKernels(available);
  // Read once, before any thread of the servo loop exists.
  const char* wanted = std::getenv("PALPATE_SIMD");  // NOLINT(concurrency-mt-unsafe)
  for (int i = 0; wanted != nullptr && i < count; ++i) {
    if (std::strcmp(available[i]->name, wanted) == 0) return available[i];
  }
  return available[count - 1];
}

std::atomic<const Kernels*>& Active() {
  static std::atomic<const Kernels*> active{Choose()};
  return active;
}

}  // namespace

int AvailableKernels(const Kernels* out[3]) {
  int count = 0;
  out[count++] = &kScalarKernels;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) out[count++] = &kAvx2Kernels;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    out[count++] = &kAvx512Kernels;
  }
  return count;
}

const Kernels& ActiveKernels() {
  return *Active().load(std::memory_order_relaxed);
}

void UseKernels(const Kernels& kernels) {
  Active().store(&kernels, std::memory_order_relaxed);
}

}  // namespace palpate
