#pragma once

#include <sstream>
#include <string>

#include <pybind11/pybind11.h>

/// What people read: help(), and how objects show themselves.
namespace palpate {

namespace py = pybind11;

/// The texts that help() shows for functions, from the stub.
class Prose {
 public:
  Prose() : texts_(py::module_::import("palpate._prose").attr("read")("__init__.pyi")) {}
  /// Returns a text, valid while this object lives.  Throws for a name that the stub does not have.
  const char* operator()(const char* name) const {
    const char* text = PyUnicode_AsUTF8(texts_[name].ptr());
    if (!text) throw py::error_already_set();
    return text;
  }

 private:
  py::dict texts_;
};

/// Formats a Python repr: "<palpate.Body tooth: ...>".
template <class... Parts>
std::string Shown(const char* kind, const Parts&... parts) {
  std::ostringstream text;
  text << "<palpate." << kind << ' ';
  (text << ... << parts);
  return text.str() + ">";
}
inline std::string Row(const double* x, int count) {
  std::ostringstream text;
  for (int i = 0; i < count; ++i) text << (i > 0 ? " " : "[") << x[i];
  return text.str() + "]";
}

}  // namespace palpate
