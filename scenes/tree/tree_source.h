#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <tuple>

#include "scenes/tree/tree_mode.h"

namespace palpate {

/// The most leaves of one body, built or read.
inline constexpr std::size_t kMaxLeaves = 1u << 20;

/// Where a body's leaves come from: built over its mesh, or read from a file.
struct TreeSource {
  TreeMode mode = TreeMode::kInside;  ///< of leaves that are built
  std::string file;  ///< path of a .sph file (sph_file.h); empty: the leaves are built
  int level = 0;     ///< of the file, from 1, its root; 0: its finest
  std::optional<double> metres_per_unit;  ///< unit of the file; none: that of the body's mesh
  bool align = true;  ///< whether to find the file's lost offset from the mesh: tree_alignment.h
  std::string where;  ///< "file:line: field", for later error messages

  bool built() const { return file.empty(); }
  /// Equal sources give the same leaves over the same mesh; `where` does not count.
  bool operator==(const TreeSource& other) const {
    const auto all = [](const TreeSource& s) {
      return std::tie(s.mode, s.file, s.level, s.metres_per_unit, s.align);
    };
    return all(*this) == all(other);
  }
};

}  // namespace palpate
