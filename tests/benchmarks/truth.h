#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

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

  /// @param seed  of what is added, for figures of one hand.
  explicit Tally(std::uint64_t seed = 0) : seed_(seed) {}

  // A value that is no number counts as the worst.
  void Most(std::string_view name, double value) { Add({std::string(name), Kind::kMost, value}); }
  void Least(std::string_view name, double value) { Add({std::string(name), Kind::kLeast, value}); }
  void Count(std::string_view name, double value) { Add({std::string(name), Kind::kCount, value}); }
  void Merge(const Tally& other);
  const std::vector<Figure>& figures() const { return figures_; }

 private:
  void Add(Figure figure);
  void Merge(const Figure& figure);
  std::uint64_t seed_;
  std::vector<Figure> figures_;
};

/// A hand over bodies whose right answer is known by construction.
struct TruthHand {
  Scene scene;             ///< its first tool is driven
  std::vector<Pose> X_WH;  ///< one per millisecond; the first is free
  std::function<void(std::size_t i, const StepReport& report)> see;  ///< judges a step
  std::function<void(Tally& tally)> tell;                            ///< says what was wrong
};

/// @param judge  has See and Tell.
template <class Judge>
TruthHand JudgedBy(Judge judge, Scene scene, std::vector<Pose> X_WH) {
  const auto shared = std::make_shared<Judge>(std::move(judge));
  return {std::move(scene), std::move(X_WH),
          [shared](std::size_t i, const StepReport& report) { shared->See(i, report); },
          [shared](Tally& tally) { shared->Tell(tally); }};
}

struct TruthCase {
  std::string name;  ///< PART/BODY/TOOL
  std::function<TruthHand(std::uint64_t seed)> make;
};

/// Plates flat in any tessellation under plain tools, without friction and with Coulomb's.
std::vector<TruthCase> FlatTruths();
/// Grooves and holes whose sides are such plates, and what lies in them.
std::vector<TruthCase> FoldTruths();
/// Meshes of smooth bodies.
/// @param million  whether with those of a million triangles.
std::vector<TruthCase> CurvedTruths(bool million);
/// Bars, sheets and islands through which burs go and come back.
std::vector<TruthCase> CutTruths();

}  // namespace palpate::bench
