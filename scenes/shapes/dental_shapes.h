#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

// Teeth, what is about them, and instruments: closed, manifold and oriented, in metres.

/// A simple tooth of four kinds, which only stands for one; or, from kFirstByNumber on, the teeth
/// of an adult in the order of ToothNames() (tooth_forms.h), true to form.
enum class ToothKind { kIncisor, kCanine, kPremolar, kMolar, kFirstByNumber };
/// What scene files call them.
std::span<const std::string_view> ToothKindNames();

struct ToothSize {
  double width = 0.0;  ///< of the crown along the arch, x [m]
  double depth = 0.0;  ///< of the crown across the arch, z [m]
  double crown = 0.0;  ///< height of the crown above the neck, y > 0 [m]
  double root = 0.0;   ///< length of the roots below it, y < 0 [m]
};

/// An adult's tooth of the kind.
ToothSize UsualSize(ToothKind kind);

/// Frame of a tooth: origin in the middle of its neck, y towards the chewing surface, z outwards to
/// lip or cheek.  A simple molar has four cusps and two roots, a premolar two cusps, a canine one;
/// an incisor has an edge.
TriangleMesh MakeTooth(ToothKind kind, const ToothSize& size);

/// What lies under that tooth's enamel, in the tooth's frame: the enamel is about `enamel` thick
/// over the cusps, thinner towards the neck, where it ends; at the root, which has none, the mesh
/// lies just outside of the tooth's.
TriangleMesh MakeDentine(ToothKind kind, const ToothSize& size, double enamel);

struct GumSize {
  double pocket_depth = 0.0;  ///< below the neck [m]
  double pocket_width = 0.0;  ///< [m]
  double recession = 0.0;     ///< how far the margin has gone down from the neck [m]
  /// Where one is not 0 the pocket goes all round, and these are its depths at the six sites that
  /// are probed: mesial, middle and distal outside, then inside [m].
  std::array<double, 6> sites{};
};

/// Piece of a jaw with the gum round that tooth, in the tooth's frame: it lies close to it but for
/// a pocket, at the outer side (z > 0) unless it has sites, and rises towards the neighbours, from
/// which it is cut.
TriangleMesh MakeGingiva(ToothKind kind, const ToothSize& size, const GumSize& gum);
/// The crest of that gum round the tooth, pocket and all: a closed curve, counter-clockwise seen
/// from above.
std::vector<Vec3> GingivalMargin(ToothKind kind, const ToothSize& size, const GumSize& gum);

/// Rough lump that lies on that tooth's outer side just above its neck and reaches into it, in the
/// tooth's frame; about `width` across.
TriangleMesh MakeCalculus(ToothKind kind, const ToothSize& size, double width);

/// Parts of a lower jaw without teeth, from one cut across it to another.
enum class JawPart {
  kBone,    ///< all of it
  kMarrow,  ///< what lies within the hard cortex: cancellous bone
  kNerve,   ///< the nerve in its canal, towards the lower border
};
/// One frame: origin in the middle, x along the jaw, which bends round its inner side, y up, z
/// outwards; 16 mm high and 10 mm thick.  Marrow and nerve end beyond the bone's ends.
/// @param cortex  about how thick it is [m].   @param length  along the jaw [m].
TriangleMesh MakeMandible(JawPart part, double length, double cortex);

/// Periodontal probe: a thin tapered tip with a round end, bent off a shank, and a handle.
/// Frame: origin at the tip's end, the tip along +y; the handle leans towards +z.
TriangleMesh MakeProbe(double tip_radius, double length);
/// Scaler: as the probe, but its tip is a hook that points to -z and ends sharper.
TriangleMesh MakeScaler(double tip_radius, double length);

}  // namespace palpate
