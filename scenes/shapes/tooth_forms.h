#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "scenes/shapes/implicit_mesh.h"

namespace palpate {

// The 28 teeth of an adult without wisdom teeth, each of its own form.  Dimensions and forms follow
// Wheeler's Dental Anatomy approximately.  Lengths here are in millimetres, as usual in dentistry.

/// The number of a tooth by ISO 3950 (FDI): the quadrant, 1 to 4 (upper right, upper left, lower
/// left, lower right), and the place from the middle, 1 to 7.
struct ToothNumber {
  int quadrant = 1;
  int place = 1;
  bool upper() const { return quadrant <= 2; }
};

/// Returns the names in scene files: "11" to "17", "21" to "27", and so on.
std::span<const std::string_view> ToothNames();
/// @param name  index into ToothNames().
ToothNumber NumberOf(std::size_t name);

/// Width of the crown along the arch, its depth across it, its height above the neck, and the
/// length of the roots [mm].
struct ToothMeasures {
  double width, depth, crown, root;
};
ToothMeasures MeasuresOf(ToothNumber tooth);

/// Returns the tooth in its frame: origin in the middle of its neck, y towards the chewing
/// surface, z outwards to lip or cheek.  The middle of the arch is towards +x in quadrants 2 and 4
/// and towards -x in the others, in the arrangement of ArchOf, in which an upper jaw is turned
/// over about z.
Field ToothFormField(ToothNumber tooth, const ToothMeasures& size);
TriangleMesh MakeToothForm(ToothNumber tooth, const ToothMeasures& size);  ///< [m]

/// Semi-axes of the ellipse whose front half a jaw's teeth follow, across and forward [mm].
struct ArchAxes {
  double half_width, length;
};
ArchAxes ArchOf(bool upper);

/// The place of a tooth in its jaw, whose teeth point to +y and whose necks lie in y = 0: at (x, 0,
/// z), turned about y by `angle` [mm, rad].
struct PlacedTooth {
  ToothNumber number;
  double x, z, angle;
};
/// Returns a jaw's 14 teeth from +x to -x, each touching the next.
std::vector<PlacedTooth> TeethOf(bool upper);

}  // namespace palpate
