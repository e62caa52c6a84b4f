#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::bench {

/// Figures of any number of hands: greatest and least values, each with the seed that gave it, and
/// counts.
class Tally {
 public:
  enum class Kind { kMost, kLeast, kCount };
  struct Figure {
    std::string name;  ///< with its unit
    Kind kind;
    double value;
    std::uint64_t seed = 0;
  };

  // A value that is no number counts as the worst.
  void Most(std::string_view name, double value, std::uint64_t seed);
  void Least(std::string_view name, double value, std::uint64_t seed);
  void Count(std::string_view name, double value);
  void Merge(const Tally& other);
  const std::vector<Figure>& figures() const { return figures_; }

 private:
  void Add(const Figure& figure);
  std::vector<Figure> figures_;
};

/// Hands over bodies whose right answer is known by construction.
struct TruthCase {
  std::string name;  ///< PART/BODY/TOOL
  /// Drives one hand and tallies what is wrong.
  std::function<void(std::uint64_t seed, Tally& tally)> run;
};

/// Plates flat in any tessellation under plain tools, without friction and with Coulomb's.
std::vector<TruthCase> FlatTruths();

}  // namespace palpate::bench
