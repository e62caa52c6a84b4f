#pragma once

#include "scenes/scene.h"

namespace palpate {

// What is soft in a mouth, closed, manifold and oriented, in metres.

/// A jaw's gum with its teeth's roots in it: it ends at each neck in a margin, rises between the
/// teeth as papillae, and shows the roots below.  An upper jaw has a palate, a lower one a floor.
/// The frame is that of TeethOf (tooth_forms.h): the teeth stand in it and point to +y.
TriangleMesh MakeJaw(bool upper);

/// Tongue with a groove along its middle and a tip towards +z; `length` from root to tip.
TriangleMesh MakeTongue(double length);

/// Lips and cheeks held open round a mouth, whose middle is the origin; y up, z forward.  Closed
/// behind by the throat, so that one sees no further.
TriangleMesh MakeFace(double mouth_width, double mouth_height);

}  // namespace palpate
