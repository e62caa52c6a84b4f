#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <tuple>

#include "scenes/tree/tree_mode.h"

namespace palpate {

/// Of one body, whatever they come from.
inline constexpr std::size_t kMaxLeaves = 1u << 20;

/// Where a body's leaves come from: they are built over its mesh, or read from a file.
struct TreeSource {
  TreeMode mode = TreeMode::kInside;  ///< of those that are built
  std::string file;                   ///< a .sph file's path (sph_file.h); empty: they are built
  int level = 0;                      ///< of the file, from 1, its root; 0: its finest
  std::optional<double> metres_per_unit;  ///< of the file; none: as of the body's mesh
  bool align = true;                      ///< the file has lost where the mesh is: tree_alignment.h
  std::string where;                      ///< "file:line: field", for complaints that come later

  bool built() const { return file.empty(); }
  /// Makes the same leaves over the same mesh.
  bool operator==(const TreeSource& other) const {
    const auto all = [](const TreeSource& s) {
      return std::tie(s.mode, s.file, s.level, s.metres_per_unit, s.align);
    };
    return all(*this) == all(other);
  }
};

}  // namespace palpate
