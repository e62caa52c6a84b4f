#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// A parameter of a shape, a number in the scene file.
struct ShapeParameter {
  std::string_view field;  ///< ends with the unit in the file, _mm or _deg; else a plain number
  double usual = 0.0;      ///< default, in the file's unit; 0: by variant
  double smallest = 0.0, largest = 0.0;  ///< in the file's unit
  double unit = 1.0;                     ///< SI value of the file's unit
};

/// A shape that scene files name: "shape": name, "kind": one of its variants.
struct ShapeKind {
  std::string_view name;
  std::vector<std::string_view> variants;  ///< empty: "kind" is not allowed
  std::vector<ShapeParameter> parameters;
  /// @param variant  index.   @param values  one per parameter, in SI.
  TriangleMesh (*make)(std::size_t variant, std::span<const double> values);
  /// Returns the shape's gingival margin (Body::margin); null: it has none.
  std::vector<Vec3> (*margin)(std::size_t variant, std::span<const double> values) = nullptr;
  /// Returns the shape's cutting part (Body::bur); null: it has none.  A variant beyond the last
  /// one is a curve: (rho, z), (rho, z), ... follow the parameters' values [m].
  BurProfile (*bur)(std::size_t variant, std::span<const double> values) = nullptr;
};

/// Returns all kinds (scenes/catalogue/README.md describes each).
std::span<const ShapeKind> ShapeKinds();

/// Returns null if there is no kind of that name.
const ShapeKind* FindShapeKind(std::string_view name);

/// The arguments of a kind's `make` and `bur`.
struct ShapeChoice {
  std::size_t variant = 0;
  std::vector<double> values;
};
/// Returns a choice of the shape "bur", by its ISO 6360 number (BurOfIso).
ShapeChoice BurNamed(const std::string& name);

}  // namespace palpate
