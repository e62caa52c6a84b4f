#include "server/physics/simd/kernels.inl"

namespace palpate {
const Kernels kAvx512Kernels = MakeKernels("avx512");
}  // namespace palpate
