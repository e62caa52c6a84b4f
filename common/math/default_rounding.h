#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace palpate {

/// While it lives, its thread's arithmetic is that of a new process: rounds to nearest, keeps
/// subnormal numbers, and raises no signal.  A host of the library may have left another mode, as
/// may a plug-in that was linked with -ffast-math, and would get other bits.  The host's mode comes
/// back afterwards.  What must not see it is a function of its own that is not inlined, because
/// compilers do not know that arithmetic depends on the mode.  Real-time.
class DefaultRounding {
 public:
#if defined(__SSE2__)
  DefaultRounding() noexcept : host_(_mm_getcsr()) {
    if ((host_ & kMode) != kDefault) _mm_setcsr((host_ & ~kMode) | kDefault);
  }
  ~DefaultRounding() {
    const unsigned now = _mm_getcsr();
    if (((now ^ host_) & kMode) != 0) _mm_setcsr((now & ~kMode) | (host_ & kMode));
  }

 private:
  // MXCSR (Intel SDM 1, 10.2.3): flush to zero and rounding, the masks of exceptions, and
  // "denormals are zeros"; by default only the masks are set.
  static constexpr unsigned kMode = 0xFFC0, kDefault = 0x1F80;
  unsigned host_;
#else
  DefaultRounding() noexcept {
    std::feholdexcept(&host_);
    std::fesetround(FE_TONEAREST);
  }
  ~DefaultRounding() {
    std::fesetenv(&host_);
  }

 private:
  std::fenv_t host_;
#endif

 public:
  DefaultRounding(const DefaultRounding&) = delete;
  DefaultRounding& operator=(const DefaultRounding&) = delete;
};

}  // namespace palpate
