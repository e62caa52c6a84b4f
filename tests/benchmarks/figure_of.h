#pragma once

#include <cmath>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/benchmarks/truth.h"

namespace palpate::bench {

template <class Judge>
double FigureOf(const Judge& judge, std::string_view name) {
  Tally tally;
  judge.Tell(tally);
  for (const Tally::Figure& f : tally.figures()) {
    if (f.name == name) return f.value;
  }
  ADD_FAILURE() << "no figure " << name;
  return NAN;
}

}  // namespace palpate::bench
