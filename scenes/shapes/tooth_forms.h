#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "scenes/shapes/implicit_mesh.h"

namespace palpate {

// The 28 teeth of an adult without wisdom teeth, told apart by form.  Measures and forms are about
// those of Wheeler's Dental Anatomy; all lengths here are in millimetres, the unit of the trade.

/// A tooth by its number after ISO 3950 (FDI): the quadrant, 1 to 4 (upper right, upper left, lower
/// left, lower right), and the place from the middle, 1 to 7.
struct ToothNumber {
  int quadrant = 1;
  int place = 1;
  bool upper() const { return quadrant <= 2; }
};

/// "11" to "17", "21" to "27", and so on: the names that scene files give.
std::span<const std::string_view> ToothNames();
/// @param name  index into ToothNames().
ToothNumber NumberOf(std::size_t name);

/// The crown's width along the arch and depth across it, its height above the neck, and the length
/// of the roots below it [mm].
struct ToothMeasures {
  double width, depth, crown, root;
};
ToothMeasures MeasuresOf(ToothNumber tooth);

/// The tooth in its frame: origin in the middle of its neck, y towards the chewing surface, z
/// outwards to lip or cheek; towards the middle of the arch is +x in quadrants 2 and 4 and -x in
/// the others, where a jaw's teeth stand as ArchOf has them and an upper jaw is turned over about
/// z.
Field ToothFormField(ToothNumber tooth, const ToothMeasures& size);
TriangleMesh MakeToothForm(ToothNumber tooth, const ToothMeasures& size);  ///< [m]

/// Half-axes of the ellipse along whose front half a jaw's teeth stand, across and forward [mm].
struct ArchAxes {
  double half_width, length;
};
ArchAxes ArchOf(bool upper);

/// Where a tooth stands in its jaw, whose teeth point to +y and whose necks lie in y = 0: at
/// (x, 0, z), turned about y by `angle` [mm, rad].
struct PlacedTooth {
  ToothNumber number;
  double x, z, angle;
};
/// A jaw's 14 teeth from +x to -x, each touching the next.
std::vector<PlacedTooth> TeethOf(bool upper);

}  // namespace palpate
