#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace palpate {
namespace {

/// Functions of the C library whose last bits depend on its version and on the processor.  (IEEE
/// 754 fixes those of sqrt, fma, fmod, ldexp and of the roundings.)
bool IsInexact(std::string name) {
  static const std::set<std::string> kInexact{
      "acos",  "acosh", "asin",   "asinh", "atan", "atan2",  "atanh", "cbrt", "cos",  "cosh",
      "erf",   "erfc",  "exp",    "exp10", "exp2", "expm1",  "hypot", "j0",   "log",  "log10",
      "log1p", "log2",  "lgamma", "pow",   "sin",  "sincos", "sinh",  "tan",  "tanh", "tgamma"};
  if (kInexact.contains(name)) return true;
  if (name.empty() || (name.back() != 'f' && name.back() != 'l')) return false;
  name.pop_back();
  return kInexact.contains(name);
}

/// Returns the inexact functions that a file of objects calls, each with the object.
std::vector<std::string> InexactCalls(const std::string& file) {
  test::Program nm("/usr/bin/nm", {"--undefined-only", "--print-file-name", file});
  EXPECT_EQ(nm.Exit(), 0) << nm.Output();
  std::vector<std::string> calls;
  std::istringstream lines(nm.Output());
  for (std::string line; std::getline(lines, line);) {  // libx.a:y.cpp.o:      U sin@GLIBC_2.2.5
    std::string name = line.substr(line.rfind(' ') + 1);
    name = name.substr(0, name.find('@'));
    if (IsInexact(name)) calls.push_back(line.substr(line.rfind('/') + 1));
  }
  return calls;
}

// Therefore the bytes of a scene, and the forces on it, are the same with every C library.
TEST(LibM, IsNotCalledByWhatMakesASceneOrAStep) {
  for (const std::string file : {PALPATE_LIBRARIES}) {
    EXPECT_EQ(InexactCalls(file), std::vector<std::string>{}) << "use common/math/elementary.h";
  }
}

TEST(LibM, IsFoundWhereItIsCalled) {
  EXPECT_NE(InexactCalls(PALPATE_PICTURES), std::vector<std::string>{});
}

}  // namespace
}  // namespace palpate
