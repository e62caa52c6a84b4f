#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "scenes/scene.h"

namespace palpate {

/// How the leaves of a sphere tree stand for the solid.
enum class TreeMode : std::uint8_t {
  /// Every leaf inside it: most touch the surface at points spread evenly over it, some fill what
  /// these leave free inside, and the rest goes where the surface lies furthest from all others.
  kInside,
  /// Those at the surface moved and resized, until what a hand feels of them errs least
  /// (balanced_balls.h): their surface lies outside the solid's as much as inside.
  kBalanced,
  /// Those at the surface moved and resized, until they hold all of it and stick out least
  /// (cover_balls.h): they bound it.
  kCover,
  /// The circumscribed balls of an octree's cells (octree_balls.h): what textbooks begin with, to
  /// compare the others with.
  kOctree,
};

/// What scene files and programs call them, in the order of TreeMode.
inline constexpr std::array<std::string_view, 4> kTreeModes{"inside", "balanced", "cover",
                                                            "octree"};
inline std::string_view NameOf(TreeMode mode) {
  return kTreeModes[static_cast<std::size_t>(mode)];
}
/// @param name  one of kTreeModes.
inline TreeMode TreeModeNamed(std::string_view name) {
  return static_cast<TreeMode>(std::find(kTreeModes.begin(), kTreeModes.end(), name) -
                               kTreeModes.begin());
}

/// What suits a contact, where nobody says otherwise: balanced leaves where they are what is felt;
/// else those inside, which never reach further than the mesh.
inline TreeMode ModeFor(ContactModel contact) {
  return contact == ContactModel::kSpheres ? TreeMode::kBalanced : TreeMode::kInside;
}

/// Of a tree that was built in the mode.
inline TreeOrigin OriginOf(TreeMode mode) {
  static_assert(static_cast<int>(TreeOrigin::kInside) == 1 + static_cast<int>(TreeMode::kInside) &&
                static_cast<int>(TreeOrigin::kOctree) == 1 + static_cast<int>(TreeMode::kOctree));
  return static_cast<TreeOrigin>(1 + static_cast<int>(mode));
}
/// One of kTreeModes, "file", "ball" or "unknown".
inline std::string_view NameOf(TreeOrigin origin) {
  switch (origin) {
    case TreeOrigin::kUnknown:
      return "unknown";
    case TreeOrigin::kFile:
      return "file";
    case TreeOrigin::kBall:
      return "ball";
    default:
      return kTreeModes[static_cast<std::size_t>(origin) - 1];
  }
}

}  // namespace palpate
