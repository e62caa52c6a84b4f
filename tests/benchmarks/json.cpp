#include "tests/benchmarks/json.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace palpate::bench {

Json::Json(double value) : text_(nlohmann::json(value).dump()) {}
Json::Json(const char* text) : text_(nlohmann::json(text).dump()) {}
Json::Json(const std::string& text) : text_(nlohmann::json(text).dump()) {}

Json::Json(std::initializer_list<Member> members) : kind_(Kind::kObject), members_(members) {}

Json Json::Array() {
  return std::vector<Json>();
}

Json Json::Parse(const std::string& text) {
  const auto parsed = nlohmann::ordered_json::parse(text);
  Json json;
  if (!parsed.is_structured()) {
    json.text_ = text;
    return json;
  }
  json.kind_ = parsed.is_array() ? Kind::kArray : Kind::kObject;
  for (const auto& [name, value] : parsed.items()) {
    json.members_.emplace_back(name, Parse(value.dump()));
  }
  return json;
}

Json& Json::operator[](const std::string& name) {
  kind_ = Kind::kObject;
  const auto found = std::find_if(members_.begin(), members_.end(),
                                  [&](const Member& member) { return member.first == name; });
  return found != members_.end() ? found->second : members_.emplace_back(name, Json()).second;
}

void Json::push_back(Json element) {
  kind_ = Kind::kArray;
  members_.emplace_back("", std::move(element));
}

void Json::update(const Json& object) {
  for (const auto& [name, value] : object.members_) (*this)[name] = value;
}

std::string Json::Text(std::size_t depth) const {
  if (kind_ == Kind::kScalar) return text_;
  const bool array = kind_ == Kind::kArray;
  std::string text(1, array ? '[' : '{');
  for (const auto& [name, value] : members_) {
    text += text.size() == 1 ? "\n" : ",\n";
    text.append(2 * (depth + 1), ' ');
    if (!array) text += nlohmann::json(name).dump() + ": ";
    text += value.Text(depth + 1);
  }
  if (!members_.empty()) text.append(1, '\n').append(2 * depth, ' ');
  return text + (array ? ']' : '}');
}

}  // namespace palpate::bench
