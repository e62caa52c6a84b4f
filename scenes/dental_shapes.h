#pragma once

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

// A mouth's worth of shapes, closed, manifold and oriented, in metres.  They are recognisable, not
// anatomical: measures are about those of Wheeler's Dental Anatomy.

enum class ToothKind { kIncisor, kCanine, kPremolar, kMolar };

struct ToothSize {
  double width = 0.0;  ///< of the crown along the arch, x [m]
  double depth = 0.0;  ///< of the crown across the arch, z [m]
  double crown = 0.0;  ///< height of the crown above the neck, y > 0 [m]
  double root = 0.0;   ///< length of the roots below it, y < 0 [m]
};

/// An adult's tooth of the kind.
ToothSize UsualSize(ToothKind kind);

/// Frame of a tooth: origin in the middle of its neck, y towards the chewing surface, z outwards to
/// lip or cheek.  A molar has four cusps and two roots, a premolar two cusps, a canine one; an
/// incisor has an edge.
TriangleMesh MakeTooth(ToothKind kind, const ToothSize& size);

/// Gum round that tooth, in the tooth's frame: it lies close to it but for a pocket at the outer
/// side (z > 0), `pocket_width` wide and `pocket_depth` deep below the neck.
TriangleMesh MakeGingiva(ToothKind kind, const ToothSize& size, double pocket_depth,
                         double pocket_width);

/// Rough lump that lies on that tooth's outer side just above its neck and reaches into it, in the
/// tooth's frame; about `width` across.
TriangleMesh MakeCalculus(ToothKind kind, const ToothSize& size, double width);

/// Periodontal probe: a thin tapered tip with a round end, bent off a shank, and a handle.
/// Frame: origin at the tip's end, the tip along +y; the handle leans towards +z.
TriangleMesh MakeProbe(double tip_radius, double length);
/// Scaler: as the probe, but its tip is a hook that points to -z and ends sharper.
TriangleMesh MakeScaler(double tip_radius, double length);

/// Half-axes of the ellipse along which the teeth of a jaw stand: across, x, and forward, z [m].
/// The arch is its front half; teeth point to +y and their necks lie in y = 0.
struct Arch {
  double half_width = 0.0, length = 0.0;
};
Arch UsualArch(bool upper);
/// Ridge with sockets for 14 teeth; an upper jaw has a palate.
TriangleMesh MakeJaw(bool upper);

/// Tongue with a groove along its middle and a tip towards +z; `length` from root to tip.
TriangleMesh MakeTongue(double length);

/// Mask of a face, open behind, with nose, eyes, chin, lips and an open mouth, whose middle is the
/// origin; y up, z forward.
TriangleMesh MakeFace(double mouth_width, double mouth_height);

}  // namespace palpate
