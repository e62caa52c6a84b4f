#pragma once

#include <string>
#include <string_view>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "common/error.h"
#include "common/math/pose.h"
#include "common/math/pose_check.h"

/// Numpy's arrays as the modules of Python take and give them.
namespace palpate {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// As numbers are given: whole ones and floats, which a double holds.  Those that numpy would make
/// others of without a word, as complex, masked, longer or written-out ones, are an Error.
/// @param what  for the message.
inline py::array ToNumbers(const py::object& given, const std::string& what) {
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asanyarray")(given);
    if (py::hasattr(array, "mask") &&
        py::module_::import("numpy.ma").attr("is_masked")(array).cast<bool>()) {
      throw Error(what + ": some of its numbers are masked; leave them out, or fill them");
    }
  } catch (const py::error_already_set& error) {
    throw Error(what + ": is no array of numbers (" + py::str(error.value()).cast<std::string>() +
                ")");
  }
  const py::dtype dtype = array.dtype();
  if (std::string_view("fiu").find(dtype.kind()) == std::string_view::npos ||
      dtype.itemsize() > 8) {
    throw Error(what + ": is an array of " + py::str(py::handle(dtype)).cast<std::string>() +
                "; give real numbers, as numpy.asarray(it, dtype=float) makes them of what it can");
  }
  return array;
}

inline Doubles ToDoubles(const py::object& given, const std::string& what) {
  return Doubles(ToNumbers(given, what));
}

/// Throws Error where an array is of another shape than is wanted.
/// @param what, wanted  for the message.
inline void RequireShape(bool is_so, const py::array& array, const std::string& what,
                         const std::string& wanted) {
  if (is_so) return;
  throw Error(what + ": must be " + wanted + "; its shape is " +
              std::string(py::str(array.attr("shape"))));
}

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

/// Throws Error where it has another shape, a number is not finite, or the quaternion is not of
/// length 1.
/// @param given  x y z, or x y z w x y z.
/// @param what   for the message.
inline Pose ToCheckedPose(const py::object& given, const char* what = "pose") {
  const Doubles array = ToDoubles(given, what);
  RequireShape(array.ndim() == 1 && (array.shape(0) == 3 || array.shape(0) == 7), array, what,
               "x y z, or x y z w x y z, in metres and as a unit quaternion");
  Pose X = ToPose(array.data(), array.shape(0));
  if (!IsPose(X)) {
    throw Error(std::string(what) + ": must be finite, its quaternion w x y z of length 1");
  }
  return X;
}
inline Pose ToUnitPose(const py::object& given, const char* what = "pose") {
  Pose X = ToCheckedPose(given, what);
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
