#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "scenes/scene.h"

namespace palpate {

/// The most leaves of one body.
inline constexpr std::size_t kMaxLeaves = 1u << 20;

/// How the leaves of a sphere tree represent the solid.
enum class TreeMode : std::uint8_t {
  /// All leaves lie inside it.  Most touch the surface, at evenly spread points; some fill the
  /// space left inside; and the rest goes where the surface is furthest from all others.
  kInside,
  /// The leaves at the surface are moved and resized until the error that a hand feels is least
  /// (balanced_balls.h): their union is as often above the surface as below it.
  kBalanced,
};

/// The modes' names in scene files and programs, in the order of TreeMode.
inline constexpr std::array<std::string_view, 2> kTreeModes{"inside", "balanced"};
inline std::string_view NameOf(TreeMode mode) {
  return kTreeModes[static_cast<std::size_t>(mode)];
}
/// @param name  one of kTreeModes.
inline TreeMode TreeModeNamed(std::string_view name) {
  return static_cast<TreeMode>(std::find(kTreeModes.begin(), kTreeModes.end(), name) -
                               kTreeModes.begin());
}

/// Returns the default mode for a contact model: balanced if the leaves are felt, else inside,
/// whose leaves never reach further than the mesh.
inline TreeMode ModeFor(ContactModel contact) {
  return contact == ContactModel::kSpheres ? TreeMode::kBalanced : TreeMode::kInside;
}

/// Returns the origin of a tree that was built in the mode.
inline TreeOrigin OriginOf(TreeMode mode) {
  static_assert(static_cast<int>(TreeOrigin::kInside) == 1 + static_cast<int>(TreeMode::kInside) &&
                static_cast<int>(TreeOrigin::kBalanced) ==
                    1 + static_cast<int>(TreeMode::kBalanced));
  return static_cast<TreeOrigin>(1 + static_cast<int>(mode));
}
/// Returns one of kTreeModes, "cover", "octree", "file", "ball" or "unknown".
inline std::string_view NameOf(TreeOrigin origin) {
  switch (origin) {
    case TreeOrigin::kUnknown:
      return "unknown";
    case TreeOrigin::kCover:
      return "cover";
    case TreeOrigin::kOctree:
      return "octree";
    case TreeOrigin::kFile:
      return "file";
    case TreeOrigin::kBall:
      return "ball";
    default:
      return kTreeModes[static_cast<std::size_t>(origin) - 1];
  }
}

}  // namespace palpate
