#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// A number that a shape takes from the scene file.
struct ShapeParameter {
  std::string_view field;  ///< ends with its unit as written: _mm or _deg; else a plain number
  double usual = 0.0;      ///< where the file leaves it out, as written; 0: what the variant has
  double smallest = 0.0, largest = 0.0;  ///< as written
  double unit = 1.0;                     ///< SI of one, as written
};

/// A shape that scene files make by its name: "shape": name, "kind": one of its variants.
struct ShapeKind {
  std::string_view name;
  std::vector<std::string_view> variants;  ///< none: "kind" is not for it
  std::vector<ShapeParameter> parameters;
  /// @param variant  index.   @param values  one a parameter, in SI.
  TriangleMesh (*make)(std::size_t variant, std::span<const double> values);
  /// Its gingival margin (Body::margin); null: it has none.
  std::vector<Vec3> (*margin)(std::size_t variant, std::span<const double> values) = nullptr;
  /// What of it cuts (Body::bur); null: nothing.  A variant beyond all others is a curve: (rho, z),
  /// (rho, z), ... behind the parameters' values [m].
  BurProfile (*bur)(std::size_t variant, std::span<const double> values) = nullptr;
};

/// All of them (scenes/catalogue/README.md says what each looks like).
std::span<const ShapeKind> ShapeKinds();

/// Null where there is none of that name.
const ShapeKind* FindShapeKind(std::string_view name);

/// What `make` and `bur` of a kind are called with.
struct ShapeChoice {
  std::size_t variant = 0;
  std::vector<double> values;
};
/// Of the shape "bur": one by its ISO 6360 number (BurOfIso).
ShapeChoice BurNamed(const std::string& name);

}  // namespace palpate
