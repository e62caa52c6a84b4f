#include "server/physics/simd/kernels.inl"

namespace palpate {
const Kernels kAvx2Kernels = MakeKernels("avx2");
}  // namespace palpate
