#include "tests/benchmarks/machine.h"

#include "server/physics/simd/kernels.h"

namespace palpate::bench {

Machine ThisMachine() {
  return {ThisHost(), ActiveKernels().name};
}

Json ToJson(const Machine& machine) {
  return {{"cpu", machine.cpu},
          {"cores", machine.cores},
          {"simd", machine.simd},
          {"compiler", machine.compiler}};
}

}  // namespace palpate::bench
