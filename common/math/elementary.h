#pragma once

namespace palpate {

/// Elementary functions made of additions, multiplications, divisions and square roots alone, which
/// IEEE 754 rounds in one way.  The last bits of a C library's functions depend on its version and
/// on the processor (glibc chooses by whether it has FMA), and with them the bytes of a scene whose
/// shapes are computed, and the forces on it.  True to 3 units in the last place, Atan2 to 5, Pow
/// to 2 |y log x| more.  Real-time: no allocation, lock, log or clock.
/// Rejected: SLEEF's deterministic functions, as users of the library need Eigen alone.

/// @param x  [rad], at most 1e5 in size: beyond, the reduction by pi/2 loses bits.
double Sin(double x) noexcept;
double Cos(double x) noexcept;
/// Returns the angle of the vector (x, y) in [-pi, pi], and 0 for the zero vector.
double Atan2(double y, double x) noexcept;
double Exp(double x) noexcept;
/// Returns -infinity for 0, and NaN below.
double Log(double x) noexcept;
/// Returns x to the power of y, for x >= 0; NaN below.
double Pow(double x, double y) noexcept;
/// Returns the length of (x, y), which must not be so large that its square overflows.
double Length(double x, double y) noexcept;

}  // namespace palpate
