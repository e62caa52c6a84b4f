#include "tests/benchmarks/machine.h"

#include "server/physics/simd/kernels.h"

namespace palpate::bench {

Machine ThisMachine() {
  return {ThisHost(), ActiveKernels().name};
}

}  // namespace palpate::bench
