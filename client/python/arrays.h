#pragma once

#include <cmath>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "common/error.h"
#include "common/math/pose.h"

/// Numpy's arrays as the modules of Python take and give them.
namespace palpate {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

inline py::array_t<double> FromNumbers(const double* numbers, py::ssize_t count) {
  return py::array_t<double>(count, numbers);
}
inline py::array_t<double> FromVec3(const Vec3& v) {
  return FromNumbers(v.data(), 3);
}

/// @param row    x y z, or x y z w x y z.
/// @param width  3 or 7.
inline Pose ToPose(const double* row, py::ssize_t width) {
  Pose X;
  X.p = Vec3::Map(row);
  if (width == 7) X.q = Quat(row[3], row[4], row[5], row[6]);
  return X;
}

/// Throws Error where the array has another shape; its numbers are as they come.
/// @param array  x y z, or x y z w x y z.
/// @param what   for the message.
inline Pose ToPose(const Doubles& array, const char* what = "pose") {
  if (array.ndim() != 1 || (array.shape(0) != 3 && array.shape(0) != 7)) {
    throw Error(std::string(what) +
                ": must be x y z, or x y z w x y z, in metres and as a unit quaternion");
  }
  return ToPose(array.data(), array.shape(0));
}

/// The same with a quaternion of length 1.  Throws Error where it is not nearly so, or a number is
/// not finite.
inline Pose ToUnitPose(const Doubles& array, const char* what = "pose") {
  Pose X = ToPose(array, what);
  if (!X.p.allFinite() || !(std::abs(X.q.squaredNorm() - 1.0) < 1e-3)) {
    throw Error(std::string(what) + ": must be finite, its quaternion w x y z of length 1");
  }
  X.q.normalize();
  return X;
}

inline void FromPose(const Pose& X, double* row) {
  Vec3::Map(row) = X.p;
  row[3] = X.q.w();
  row[4] = X.q.x();
  row[5] = X.q.y();
  row[6] = X.q.z();
}
inline py::array_t<double> FromPose(const Pose& X) {
  double row[7];
  FromPose(X, row);
  return FromNumbers(row, 7);
}

}  // namespace palpate
