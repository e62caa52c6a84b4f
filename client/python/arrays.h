#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "client/python/held_wrench.h"
#include "common/error.h"
#include "common/math/pose.h"
#include "common/math/pose_check.h"

/// Conversion of NumPy arrays, for the Python modules.
namespace palpate {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Returns an array of integers or floats that a double can hold.  Throws Error for arrays that
/// NumPy would convert silently: complex, masked, text, or of longer numbers.
/// @param what  for the message.
inline py::array ToNumbers(const py::object& given, const std::string& what) {
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asanyarray")(given);
    if (py::hasattr(array, "mask") &&
        py::module_::import("numpy.ma").attr("is_masked")(array).cast<bool>()) {
      throw Error(what + ": some of its numbers are masked; remove or fill them");
    }
  } catch (const py::error_already_set& error) {
    const auto why = py::str(error.value()).cast<std::string>();
    throw Error(
        what + ": is not an array of numbers (" +
        (why.find("inhomogeneous") == std::string::npos ? why : "its rows differ in length") + ")");
  }
  const py::dtype dtype = array.dtype();
  if (std::string_view("fiu").find(dtype.kind()) == std::string_view::npos ||
      dtype.itemsize() > 8) {
    if (array.ndim() == 0) {
      const auto type = py::type::of(given).attr("__name__").cast<std::string>();
      throw Error(what + ": is of type " + type + "; give real numbers");
    }
    throw Error(what + ": is an array of " + py::str(py::handle(dtype)).cast<std::string>() +
                "; give real numbers, for example by numpy.asarray(..., dtype=float)");
  }
  return array;
}

inline Doubles ToDoubles(const py::object& given, const std::string& what) {
  return Doubles(ToNumbers(given, what));
}

/// Returns the numbers of an array of one dimension, if it is NumPy's own, of doubles in a row, and
/// sets their count; else null.  Takes tens of nanoseconds.
inline const double* PlainDoubles(py::handle given, py::ssize_t& count) {
  const auto& api = py::detail::npy_api::get();
  if (Py_TYPE(given.ptr()) != api.PyArray_Type_) return nullptr;
  const auto* const array = py::detail::array_proxy(given.ptr());
  const int flags =
      py::detail::npy_api::NPY_ARRAY_C_CONTIGUOUS_ | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  if (array->nd != 1 || (array->flags & flags) != flags) return nullptr;
  static const PyObject* const doubles = py::dtype::of<double>().release().ptr();
  if (array->descr != doubles) return nullptr;
  count = array->dimensions[0];
  return reinterpret_cast<const double*>(array->data);
}

/// Takes at most seven numbers from a list or tuple of Python's floats and integers, and returns
/// how many it has; 0 if it is another object, or longer.
inline py::ssize_t PlainFloats(py::handle given, double* numbers) {
  PyObject* const sequence = given.ptr();
  if (!PyList_CheckExact(sequence) && !PyTuple_CheckExact(sequence)) return 0;
  const py::ssize_t count = PySequence_Fast_GET_SIZE(sequence);
  if (count > 7) return 0;
  for (py::ssize_t i = 0; i < count; ++i) {
    PyObject* const item = PySequence_Fast_GET_ITEM(sequence, i);
    if (PyFloat_CheckExact(item)) {
      numbers[i] = PyFloat_AS_DOUBLE(item);
    } else if (PyLong_CheckExact(item)) {
      numbers[i] = PyLong_AsDouble(item);
      if (PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        return 0;
      }
    } else {
      return 0;
    }
  }
  return count;
}

/// Throws Error if an array does not have the wanted shape.
/// @param what, wanted  for the message.
inline void RequireShape(bool is_so, const py::array& array, const std::string& what,
                         const std::string& wanted) {
  if (is_so) return;
  throw Error(what + ": must be " + wanted + "; its shape is " +
              std::string(py::str(array.attr("shape"))));
}

inline py::array_t<double> FromNumbers(const double* numbers, py::ssize_t count) {
  // As py::array_t does, but without its vectors, which take longer than a fifth of a step.
  auto& api = py::detail::npy_api::get();
  Py_intptr_t size = count;
  PyObject* const array =
      api.PyArray_NewFromDescr_(api.PyArray_Type_, py::dtype::of<double>().release().ptr(), 1,
                                &size, nullptr, nullptr, 0, nullptr);
  if (array == nullptr) throw py::error_already_set();
  std::copy_n(numbers, count, reinterpret_cast<double*>(py::detail::array_proxy(array)->data));
  return py::reinterpret_steal<py::array_t<double>>(array);
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

/// Throws Error if the shape differs, a number is not finite, or the quaternion is not of
/// unit length.
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

inline py::array_t<double> FromTwist(const Twist& V) {
  const double six[6] = {V.v.x(), V.v.y(), V.v.z(), V.w.x(), V.w.y(), V.w.z()};
  return FromNumbers(six, 6);
}

/// Checks the settings of a force in Python before its first call, and returns them.  Throws Error
/// if one is invalid.
inline HeldWrench ToHeld(const py::object& effect, double rate_Hz, double max_force_N,
                         double max_torque_Nm) {
  if (!effect.is_none() && PyCallable_Check(effect.ptr()) == 0) {
    throw Error("effect: is not a function; give a function of hand, twist and tool, or None");
  }
  const double every = std::round(1000.0 / rate_Hz);
  if (!(every >= 1.0 && every <= 1e6 && std::abs(every * rate_Hz - 1000.0) < 1e-6)) {
    throw Error("rate_hz: must be 1000 divided by a whole number, such as 500, 100 or 40");
  }
  const auto is_bound = [](double most) { return most >= 0.0 && most <= 1e4; };
  if (!is_bound(max_force_N) || !is_bound(max_torque_Nm)) {
    throw Error("max_force, max_torque: must be from 0 to 10000");
  }
  HeldWrench held;
  held.max_force_N = max_force_N;
  held.max_torque_Nm = max_torque_Nm;
  held.every = static_cast<std::uint64_t>(every);
  return held;
}

/// Calls a force in Python, which returns a wrench, or a pair of wrench and stiffness.  Throws
/// Error if a result has another shape or is not finite; passes on what the function raises.
/// @param held  from ToHeld; receives the result and the hand's pose.
inline void Ask(const py::object& effect, const Pose& X_WH, const Twist& V_WH, const Pose& X_WG,
                HeldWrench& held) {
  py::object wrench = effect(FromPose(X_WH), FromTwist(V_WH), FromPose(X_WG));
  py::object stiffness = py::none();
  if (py::isinstance<py::tuple>(wrench) && py::len(wrench) == 2) {
    const auto both = py::reinterpret_borrow<py::tuple>(wrench);
    wrench = both[0];
    stiffness = both[1];
  }
  const py::object name = py::getattr(effect, "__name__", py::repr(effect));
  const std::string what = "effect " + py::str(name).cast<std::string>() + ": ";
  const auto numbers = [&](const py::object& given, const std::string& part) {
    Doubles array = ToDoubles(given, what + part);
    const bool is_finite = std::all_of(array.data(), array.data() + array.size(),
                                       [](double number) { return std::isfinite(number); });
    if (!is_finite) throw Error(what + part + " is not finite");
    return array;
  };
  const Doubles w = numbers(wrench, "its wrench");
  const py::ssize_t size = w.size();
  RequireShape(w.ndim() == 1 && (size == 3 || size == 6), w, what + "its wrench",
               "a force x y z in N, or that and a torque in N m");
  held.X_WH = X_WH;
  held.wrench.force = Vec3::Map(w.data());
  held.wrench.torque = size == 6 ? Vec3(Vec3::Map(w.data() + 3)) : Vec3(Vec3::Zero());
  held.stiffness.setZero();
  if (stiffness.is_none()) return;
  const Doubles k = numbers(stiffness, "its stiffness");
  RequireShape(k.ndim() == 2 && k.shape(0) == size && k.shape(1) == size, k, what + "its stiffness",
               "(3, 3) beside a force, (6, 6) beside force and torque");
  for (py::ssize_t i = 0; i < size; ++i) {
    for (py::ssize_t j = 0; j < size; ++j) held.stiffness(i, j) = k.at(i, j);
  }
}

}  // namespace palpate
