#pragma once

namespace palpate {

/// Returns the float nearest to a double.  GCC 12's vectoriser removes a conversion double -> float
/// -> double, and so loses the rounding for which a bounding radius must allow; the volatile
/// prevents this.
inline float RoundToFloat(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

}  // namespace palpate
