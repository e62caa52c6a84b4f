#pragma once

#include <cstdint>

namespace palpate {

/// Names the row of a contact, so that the next step recognises it: a part of the tool and a part
/// of a body.  Only the body's geometry interprets the number of its part.
struct ContactId {
  /// Stands in place of a body for the leaves of all objects, numbered as in the forest.
  static constexpr std::int32_t kLeaves = -1;

  std::int32_t body = kLeaves;  ///< index into SceneObjects::bodies
  std::int32_t tool = 0;        ///< leaf or triangle of the tool
  std::int32_t object = 0;      ///< leaf of the forest, or triangle of the body
  std::int32_t row = 0;         ///< which row of these two parts; between meshes, the corner

  bool IsOfLeaves() const { return body == kLeaves; }
  /// Returns whether both rows belong to the same two parts.
  bool IsBeside(const ContactId& other) const {
    return body == other.body && tool == other.tool && object == other.object;
  }
  bool operator==(const ContactId&) const = default;
};

}  // namespace palpate
