#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

// Teeth, the tissue about them, and instruments: closed, manifold and oriented meshes, in metres.

/// A simple tooth of four kinds, a rough model; or, from kFirstByNumber on, an adult's tooth in the
/// order of ToothNames() (tooth_forms.h), of natural form.
enum class ToothKind { kIncisor, kCanine, kPremolar, kMolar, kFirstByNumber };
/// Returns the kinds' names in scene files.
std::span<const std::string_view> ToothKindNames();

struct ToothSize {
  double width = 0.0;  ///< of the crown along the arch, x [m]
  double depth = 0.0;  ///< of the crown across the arch, z [m]
  double crown = 0.0;  ///< height of the crown above the neck, y > 0 [m]
  double root = 0.0;   ///< length of the roots below it, y < 0 [m]
};

/// Returns the size of an adult's tooth of the kind.
ToothSize UsualSize(ToothKind kind);

/// Makes a tooth.  Frame: origin in the middle of its neck, y towards the chewing surface, z
/// outwards to lip or cheek.  A simple molar has four cusps and two roots, a premolar two cusps, a
/// canine one, and an incisor an edge.
TriangleMesh MakeTooth(ToothKind kind, const ToothSize& size);

/// Makes the dentine of that tooth, in the tooth's frame.  The enamel over it is about `enamel`
/// thick at the cusps and thins towards the neck, where it ends.  At the root, which has no enamel,
/// the mesh lies just outside the tooth's.
TriangleMesh MakeDentine(ToothKind kind, const ToothSize& size, double enamel);

struct GumSize {
  double pocket_depth = 0.0;  ///< below the neck [m]
  double pocket_width = 0.0;  ///< [m]
  double recession = 0.0;     ///< distance of the margin below the neck [m]
  /// If any is not 0, the pocket goes all round, and these are its depths at the six sites that are
  /// probed: mesial, middle and distal outside, then inside [m].
  std::array<double, 6> sites{};
};

/// Makes a piece of jaw with the gum round that tooth, in the tooth's frame.  The gum lies close to
/// the tooth except at a pocket, which is on the outer side (z > 0) unless `sites` are given.  It
/// rises towards the neighbouring teeth, where it is cut off.
TriangleMesh MakeGingiva(ToothKind kind, const ToothSize& size, const GumSize& gum);
/// Returns the crest of that gum round the tooth, pocket included: a closed curve,
/// counter-clockwise seen from above.
std::vector<Vec3> GingivalMargin(ToothKind kind, const ToothSize& size, const GumSize& gum);

/// Makes a rough lump of calculus, about `width` across, on that tooth's outer side just above its
/// neck, in the tooth's frame; it reaches into the tooth.
TriangleMesh MakeCalculus(ToothKind kind, const ToothSize& size, double width);

/// Parts of a lower jaw without teeth, between two cross-sections.
enum class JawPart {
  kBone,    ///< all of it
  kMarrow,  ///< the inside of the hard cortex: cancellous bone
  kNerve,   ///< the nerve in its canal, towards the lower border
};
/// Makes a part.  All share one frame: origin in the middle, x along the jaw, which bends towards
/// its inner side, y up, z outwards.  The jaw is 16 mm high and 10 mm thick.  Marrow and nerve
/// extend beyond the bone's ends.
/// @param cortex  approximate thickness of it [m].   @param length  along the jaw [m].
TriangleMesh MakeMandible(JawPart part, double length, double cortex);

/// Makes a periodontal probe: a thin tapered tip with a round end, bent off a shank with a handle.
/// Frame: origin at the tip's end, the tip along +y; the handle leans towards +z.
TriangleMesh MakeProbe(double tip_radius, double length);
/// Makes a scaler: like the probe, but its tip is a hook that points to -z and is sharper.
TriangleMesh MakeScaler(double tip_radius, double length);

/// Makes a mouth mirror: a disc about the origin, whose mirror faces -z; its stem leaves the back,
/// and its handle ends at y = length.
TriangleMesh MakeMirror(double diameter, double length);

}  // namespace palpate
