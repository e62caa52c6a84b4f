#pragma once

#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace palpate::bench {

/// What a command writes: objects keep the order in which their members came.  Filled as nlohmann's
/// ordered_json, which only json.cpp includes: reading it takes a compiler longer than reading the
/// rest of a command.
class Json {
 public:
  using Member = std::pair<std::string, Json>;

  Json() = default;  ///< null, until it gets a member or an element
  Json(double value);
  Json(const char* text);
  Json(const std::string& text);
  template <std::same_as<bool> T>
  Json(T value) : text_(value ? "true" : "false") {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json(T value) : text_(std::to_string(value)) {}
  template <class T>
  Json(const std::vector<T>& values) : kind_(Kind::kArray) {
    for (const T& value : values) push_back(value);
  }
  Json(std::initializer_list<Member> members);  ///< an object

  static Json Array();
  static Json Parse(const std::string& text);

  /// The member of that name, made where there is none.
  Json& operator[](const std::string& name);
  void push_back(Json element);
  Json& back() { return members_.back().second; }
  /// Takes the members of an object over.
  void update(const Json& object);

  /// Two spaces for each level.
  std::string Text(std::size_t depth = 0) const;

 private:
  enum class Kind { kScalar, kArray, kObject };
  Kind kind_ = Kind::kScalar;
  std::string text_ = "null";    ///< a scalar as JSON
  std::vector<Member> members_;  ///< an array's have no names
};

}  // namespace palpate::bench
