#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace palpate::bench {

/// The JSON output of a command; members keep their order of insertion.
using Json = nlohmann::ordered_json;

/// The four percentiles of a sample, by nearest rank: {"p50", "p99", "p999", "max"}.
struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};
Percentiles PercentilesOf(std::vector<double> values);
Json ToJson(const Percentiles& p);

/// The least value at each index over all repeats of an identical run.
class BestOf {
 public:
  void Add(const std::vector<double>& run);
  const std::vector<double>& best() const { return best_; }
  const std::vector<double>& all() const { return all_; }

 private:
  std::vector<double> best_, all_;
};

/// A table of percentiles, one line per name.
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

/// One line of progress on stderr, overwritten by the next; nothing if stderr is no terminal.
void Progress(const std::string& line);

/// Writes one JSON object to a file, or to stdout for "-".  Throws Error if it fails.
void WriteJson(const std::string& file, const Json& json);

}  // namespace palpate::bench
