#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/course/criteria_file.h"
#include "client/replayer/verify/verify.h"
#include "scenes/grid/solid_surface.h"

namespace palpate {

/// What there was and what a session's bur left of a tissue: of all materials of that name.
struct TissueCut {
  std::string name;  ///< as the scene has it; "OBJECT" where it has none
  double before_mm3 = 0.0, after_mm3 = 0.0;
  /// While the session ran, by others' burs too.
  double removed_mm3() const { return before_mm3 - after_mm3; }
};
/// Of a scene's solids, while they are whole, by block: counted once.  Empty at first.
using WholeVolumes = std::vector<std::map<std::size_t, std::array<double, SolidGrid::kMaterials>>>;
/// In the order of solids and materials.
/// @param whole  of the same scene; null: all is counted.
std::vector<TissueCut> TissuesOf(const SolidsCut& cut, const Place& place = std::nullopt,
                                 WholeVolumes* whole = nullptr);
/// WholeSurface of each solid that is left.
std::vector<SolidSurface> SurfacesOf(const SolidsCut& cut);

/// Beside what a target left.
struct TargetDifference {
  double missed_mm3 = 0.0;  ///< gone in the target, and still there
  double excess_mm3 = 0.0;  ///< there in the target, and gone
};
/// @param tissue  empty: all.   @param target  of the same scene.
TargetDifference DifferenceTo(const SolidsCut& target, const SolidsCut& cut,
                              const std::string& tissue, const Place& place);

/// A line of insertion, to which walls are to be parallel, and the border of a preparation.
struct Preparation {
  /// Angle of the walls to the axis, the median by area; above 0 where they narrow along it. Walls
  /// lean by less than 30 degrees.  None: there are none.
  std::optional<double> taper_deg;
  double undercut_share = 0.0;  ///< of the walls' area: widens along the axis by over 1 degree
  /// Of the shoulder, from the border with what was not cut to where the wall begins, which is
  /// steeper than 45 degrees; away from the middle of the border, mean over directions.  None:
  /// there is no border.
  std::optional<double> width_mm;
  double spread_mm = 0.0;  ///< of the width (standard deviation)
  /// Of the border, from its mean over 10 degrees to either side (rms).
  double roughness_mm = 0.0;
};

/// The surface of all solids of a trial, for measures of its shape.
class CutShape {
 public:
  /// @param surfaces  its SurfacesOf.   @param tissues  its TissuesOf.
  CutShape(const SolidsCut& cut, const std::vector<SolidSurface>& surfaces,
           std::vector<TissueCut> tissues);
  explicit CutShape(const SolidsCut& cut) : CutShape(cut, SurfacesOf(cut), TissuesOf(cut)) {}

  /// Of what is left between the surface that burs made, or all of it where they made none, and a
  /// tissue that regions of the scene paint: least distance [mm], 0 where it is opened.  Parts that
  /// later regions painted over count, too.  None where no surface lies in the place.  Throws Error
  /// where no region is of that name.
  std::optional<double> ThicknessOver(const std::string& tissue, const Place& place) const;
  /// @param axis  unit, W: out of the solid.
  Preparation PreparationAlong(const Vec3& axis, const Place& place) const;
  /// TissuesOf the whole trial, counted once.
  const std::vector<TissueCut>& tissues() const { return tissues_; }

 private:
  struct Triangle {
    std::array<std::uint32_t, 3> corners;
    Vec3 normal, middle;  ///< W
    double area;
    bool is_cut;  ///< by a bur
  };
  /// Triangles on the two sides of an edge.
  struct Edge {
    std::uint32_t a, b;
    std::array<std::uint32_t, 2> triangles;
  };
  /// Triangles of the shoulder, of those that are inside.
  std::vector<bool> ShoulderFrom(const Vec3& axis, const std::vector<bool>& inside) const;
  void AddWalls(const Vec3& axis, const std::vector<bool>& inside, Preparation& found) const;
  void AddBorder(const Vec3& axis, const std::vector<bool>& inside, Preparation& found) const;

  const SolidsCut& cut_;
  std::vector<TissueCut> tissues_;
  std::vector<Vec3> vertices_;  ///< W [m]
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
};

}  // namespace palpate
