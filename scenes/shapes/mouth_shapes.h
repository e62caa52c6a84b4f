#pragma once

#include "scenes/scene.h"

namespace palpate {

// The soft parts of a mouth: closed, manifold and oriented meshes, in metres.

/// Makes the gum of a jaw with the roots of its teeth in it.  It ends at each neck in a margin,
/// rises between teeth as papillae, and bulges over the roots below.  An upper jaw has a palate, a
/// lower one a floor.  The frame is that of TeethOf (tooth_forms.h): the teeth stand in it and
/// point to +y.
TriangleMesh MakeJaw(bool upper);

/// Makes a tongue with a groove along its middle and the tip towards +z; `length` from root to tip.
TriangleMesh MakeTongue(double length);

/// Makes lips and cheeks held open round a mouth, whose middle is the origin; y up, z forward.  The
/// throat closes it behind, to block the view.
TriangleMesh MakeFace(double mouth_width, double mouth_height);

}  // namespace palpate
