#include <algorithm>

#include "tests/benchmarks/truth.h"

namespace palpate::bench {

void Tally::Add(Figure figure) {
  figure.seed = seed_;
  Merge(figure);
}

void Tally::Merge(const Figure& figure) {
  const auto same = [&](const Figure& f) { return f.name == figure.name; };
  const auto at = std::find_if(figures_.begin(), figures_.end(), same);
  if (at == figures_.end()) {
    figures_.push_back(figure);
  } else if (figure.kind == Kind::kCount) {
    at->value += figure.value;
  } else if (figure.kind == Kind::kMost ? !(figure.value <= at->value)
                                        : !(figure.value >= at->value)) {
    *at = figure;
  }
}

void Tally::Merge(const Tally& other) {
  for (const Figure& figure : other.figures_) Merge(figure);
}

}  // namespace palpate::bench
