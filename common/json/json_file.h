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

/// A value of a JSON file that people write (comments allowed), which remembers where it stands, so
/// that every complaint is an Error "file:line: field: what is wrong; remedy".  The readers below
/// check while they read: what they return is of the right type and within its bounds.
/// A node keeps its document alive; copies are cheap.
class JsonNode {
 public:
  /// Of a text: two million values, the most that one may have, of 32 letters each.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  /// Of a field's name, and of a string that is asked for: they are names, and stand in messages.
  static constexpr std::size_t kMostText = 4096;

  /// Throws Error where the file cannot be read or is not JSON, or repeats a field.
  static JsonNode Load(const std::string& file);
  /// @param file  only named in messages.
  static JsonNode Parse(std::string_view text, const std::string& file);

  /// Refuses fields that are not listed, with the nearest listed name as a guess.
  void AllowOnly(const std::vector<std::string_view>& fields) const;
  bool Has(std::string_view field) const;
  JsonNode At(std::string_view field) const;  ///< throws where the field is missing
  std::optional<JsonNode> Find(std::string_view field) const;
  std::vector<std::string> Fields() const;  ///< an object's, by name
  std::vector<JsonNode> Items(std::size_t at_least = 0) const;

  std::string String() const;  ///< not empty, and not longer than kMostText
  std::string Text() const;    ///< may be empty, and of any length: a buffer in a glTF
  std::string OneOf(const std::vector<std::string_view>& words) const;
  double Number(double min = -std::numeric_limits<double>::infinity(),
                double max = std::numeric_limits<double>::infinity()) const;
  double PositiveNumber() const;
  bool Boolean() const;
  bool IsFalse() const;  ///< the word false, not 0
  bool IsObject() const;
  bool IsString() const;
  std::int64_t Integer(std::int64_t min, std::int64_t max) const;
  /// @param most  size of an entry.
  Vec3 Vector(double most = std::numeric_limits<double>::infinity()) const;
  /// {"position_mm": [x, y, z], "rotation_deg": {"axis": [..], "angle": ..} or
  /// "quaternion_wxyz": [..]}, each optional; other fields are left to the caller's AllowOnly.
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
