#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace palpate::bench {

/// What a command writes: members stay in the order in which they came.
using Json = nlohmann::ordered_json;

/// The four figures that stand for a sample: {"p50", "p99", "p999", "max"} by nearest rank.
struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};
Percentiles PercentilesOf(std::vector<double> values);
Json ToJson(const Percentiles& p);

/// Least of the values at each index over all repeats of an identical run.
class BestOf {
 public:
  void Add(const std::vector<double>& run);
  const std::vector<double>& best() const { return best_; }
  const std::vector<double>& all() const { return all_; }

 private:
  std::vector<double> best_, all_;
};

/// A table of percentile groups: one line per name.
class Table {
 public:
  explicit Table(std::string title) : title_(std::move(title)) {}
  void Row(const std::string& name, const std::string& unit, const Percentiles& p);
  void Line(const std::string& name, const std::string& text);
  void Print() const;

 private:
  std::string title_;
  std::vector<std::string> lines_;
};

/// One line of progress on stderr, overwritten by the next; nothing where stderr is no terminal.
void Progress(const std::string& line);

/// Writes one JSON object to a file, or to stdout for "-".  Throws Error where it cannot.
void WriteJson(const std::string& file, const Json& json);

}  // namespace palpate::bench
