#pragma once

#include <cstdint>

namespace palpate {

/// What the row of a contact keeps apart, named so that it is known again in the next step: a part
/// of the tool and one of a body.  A body's geometry numbers its own parts; nothing else reads
/// them.
struct ContactId {
  /// In place of a body: the leaves of all objects, as the forest numbers them together.
  static constexpr std::int32_t kLeaves = -1;

  std::int32_t body = kLeaves;  ///< of SceneObjects::bodies
  std::int32_t tool = 0;        ///< the tool's leaf or triangle
  std::int32_t object = 0;      ///< the forest's leaf, or the body's triangle
  std::int32_t row = 0;         ///< which of the rows that these two have: of meshes, the corner

  bool IsOfLeaves() const { return body == kLeaves; }
  /// Whether it is a row of the same two parts.
  bool IsBeside(const ContactId& other) const {
    return body == other.body && tool == other.tool && object == other.object;
  }
  bool operator==(const ContactId&) const = default;
};

}  // namespace palpate
