#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// A value in a JSON file written by people (comments allowed).  It remembers its position, so that
/// every complaint is an Error "file:line: field: what is wrong; remedy".  The readers below check
/// what they return: it has the right type and is within its bounds.  A node keeps its document
/// alive; copies are cheap.
class JsonNode {
 public:
  /// Size limit of a text: two million values, the most allowed, of 32 bytes each.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  /// Size limit of field names and of strings read by String(), which serve as names and appear
  /// in messages.
  static constexpr std::size_t kMostText = 4096;

  /// Throws Error if the file cannot be read, is not JSON, or repeats a field.
  static JsonNode Load(const std::string& file);
  /// @param file  name for messages only.
  static JsonNode Parse(std::string_view text, const std::string& file);

  /// Throws Error for a field that is not listed, and suggests the nearest listed name.
  void AllowOnly(const std::vector<std::string_view>& fields) const;
  bool Has(std::string_view field) const;
  JsonNode At(std::string_view field) const;  ///< throws Error if the field is missing
  std::optional<JsonNode> Find(std::string_view field) const;
  std::vector<std::string> Fields() const;  ///< of an object, sorted by name
  std::vector<JsonNode> Items(std::size_t at_least = 0,
                              std::size_t at_most = std::size_t(-1)) const;

  std::string String() const;  ///< not empty, at most kMostText bytes
  std::string Text() const;    ///< may be empty, and of any length: a glTF buffer
  std::string OneOf(const std::vector<std::string_view>& words) const;
  double Number(double min = -std::numeric_limits<double>::infinity(),
                double max = std::numeric_limits<double>::infinity()) const;
  double PositiveNumber() const;
  bool Boolean() const;
  bool IsFalse() const;  ///< true for the literal false, not for 0
  bool IsObject() const;
  bool IsString() const;
  std::int64_t Integer(std::int64_t min, std::int64_t max) const;
  /// @param most  greatest magnitude of a component.
  Vec3 Vector(double most = std::numeric_limits<double>::infinity()) const;
  /// {"position_mm": [x, y, z], "rotation_deg": {"axis": [..], "angle": ..} or
  /// "quaternion_wxyz": [..]}, each optional; the caller's AllowOnly checks for other fields.
  Pose ReadPose() const;

  std::string Where() const;  ///< "file:line: field"
  /// Throws Error "file:line: field: message".
  [[noreturn]] void Fail(const std::string& message) const;

  struct Value;

 private:
  struct Document;
  JsonNode(std::shared_ptr<const Document> document, const Value* value, std::string path);
  const Value& Expect(int kind, const char* what) const;

  std::shared_ptr<const Document> document_;
  const Value* value_;
  std::string path_;  ///< "tools[0].leaves"; empty at the root
};

}  // namespace palpate
