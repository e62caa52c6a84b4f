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

/// The volume of a tissue before and after a session; a tissue is all materials of one name.
struct TissueCut {
  std::string name;  ///< as in the scene; "OBJECT" if it has none
  double before_mm3 = 0.0, after_mm3 = 0.0;
  /// Removed while the session ran, by others' burs too.
  double removed_mm3() const { return before_mm3 - after_mm3; }
};
/// Cache of the volumes of a scene's whole solids, by block: each is counted once.
/// Initially empty.
using WholeVolumes = std::vector<std::map<std::size_t, std::array<double, SolidGrid::kMaterials>>>;
/// Returns the tissues in the order of solids and materials.
/// @param whole  of the same scene; null: counts all blocks.
std::vector<TissueCut> TissuesOf(const SolidsCut& cut, const Place& place = std::nullopt,
                                 WholeVolumes* whole = nullptr);
/// Returns the WholeSurface of each remaining solid.
std::vector<SolidSurface> SurfacesOf(const SolidsCut& cut);

/// The difference between a trial and its target.
struct TargetDifference {
  double missed_mm3 = 0.0;  ///< removed in the target, but still there
  double excess_mm3 = 0.0;  ///< present in the target, but removed
};
/// @param tissue  empty: all.   @param target  of the same scene.
TargetDifference DifferenceTo(const SolidsCut& target, const SolidsCut& cut,
                              const std::string& tissue, const Place& place);

/// The measures of a preparation: its walls relative to an axis of insertion, and its margin.
struct Preparation {
  /// Median by area of the angle of the walls to the axis, positive if they narrow along it.  A
  /// wall leans by less than 30 degrees.  None: no walls.
  std::optional<double> taper_deg;
  /// Share of the walls' area that widens along the axis by over 1 degree.
  double undercut_share = 0.0;
  /// Mean width of the shoulder over all directions, away from the middle of the border: from the
  /// border with uncut surface to the wall, which is steeper than 45 degrees.  None: no border.
  std::optional<double> width_mm;
  double spread_mm = 0.0;  ///< standard deviation of the width
  /// Roughness (rms) of the border, relative to its mean over 10 degrees to either side.
  double roughness_mm = 0.0;
};

/// The surface of all solids of a trial, for shape measures.
class CutShape {
 public:
  /// @param surfaces  SurfacesOf(cut).   @param tissues  TissuesOf(cut).
  CutShape(const SolidsCut& cut, const std::vector<SolidSurface>& surfaces,
           std::vector<TissueCut> tissues);
  explicit CutShape(const SolidsCut& cut) : CutShape(cut, SurfacesOf(cut), TissuesOf(cut)) {}

  /// Returns the least distance [mm] from the surface that burs made to a tissue that regions of
  /// the scene paint, 0 if the tissue is opened.  Uses the whole surface if burs made none.
  /// Includes parts of the tissue that later regions painted over.  Returns none if no surface lies
  /// in the place.  Throws Error if no region has that name.
  std::optional<double> ThicknessOver(const std::string& tissue, const Place& place) const;
  /// @param axis  unit, in W, pointing out of the solid.
  Preparation PreparationAlong(const Vec3& axis, const Place& place) const;
  /// Returns TissuesOf the whole trial, computed once.
  const std::vector<TissueCut>& tissues() const { return tissues_; }

 private:
  struct Triangle {
    std::array<std::uint32_t, 3> corners;
    Vec3 normal, middle;  ///< W
    double area;
    bool is_cut;  ///< made by a bur
  };
  /// An edge and the triangles on its two sides.
  struct Edge {
    std::uint32_t a, b;
    std::array<std::uint32_t, 2> triangles;
  };
  /// Returns for each triangle whether it is of the shoulder; looks only at those inside.
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
