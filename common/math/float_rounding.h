#pragma once

namespace palpate {

/// The float nearest to a double.  A function, because GCC 12's vectoriser takes double -> float ->
/// double for nothing done, and so loses the rounding that a bounding radius must allow for; not
/// through a volatile.
inline float RoundToFloat(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

}  // namespace palpate
