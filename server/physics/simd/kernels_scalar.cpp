#include "server/physics/simd/kernels.inl"

namespace palpate {
const Kernels kScalarKernels = MakeKernels("scalar");
}  // namespace palpate
