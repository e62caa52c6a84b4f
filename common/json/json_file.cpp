#include "common/json/json_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <unordered_set>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/math/rotation.h"
#include "common/text/joined.h"
#include "common/text/nearest_word.h"
#include "common/text/without_mark.h"

namespace palpate {

struct JsonNode::Value {
  enum Kind { kNull, kBool, kNumber, kString, kArray, kObject };
  Kind kind = kNull;
  int line = 1;
  double number = 0.0;
  std::string string;
  std::string name;  // of a member of an object
  std::vector<Value> members;
};

struct JsonNode::Document {
  std::string file;
  JsonNode::Value root;
};

namespace {

using Value = JsonNode::Value;
constexpr std::size_t kMaxDepth = 32;  // far beyond any scene; bounds the recursion of destructors
/// Limit on the number of values.  Each takes 112 bytes however short its text is, so 200 MB
/// in all.
constexpr std::size_t kMaxValues = 2'000'000;

[[noreturn]] void FailAt(const std::string& file, int line, const std::string& message) {
  throw Error(file + ":" + std::to_string(line) + ": " + message);
}

const char* KindName(int kind) {
  static constexpr const char* kNames[] = {"null",     "true or false", "a number",
                                           "a string", "a list",        "an object"};
  return kNames[kind];
}

/// The parser's present position.
struct Position {
  int line = 1;
  bool at_line_end = false;  ///< the character read last ended a line
};

/// Counts lines while the parser reads.
class LineCounter {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  LineCounter(const char* at, Position* position) : at_(at), position_(position) {}
  reference operator*() const { return *at_; }
  LineCounter& operator++() {
    position_->at_line_end = *at_ == '\n';
    if (position_->at_line_end) ++position_->line;
    ++at_;
    return *this;
  }
  LineCounter operator++(int) {
    LineCounter before = *this;
    ++*this;
    return before;
  }
  bool operator==(const LineCounter& other) const { return at_ == other.at_; }
  bool operator!=(const LineCounter& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  Position* position_;
};

/// Receives the parser's events and builds the tree of values.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  Builder(const std::string& file, std::string_view text, const Position& position)
      : file_(file), text_(text), position_(position) {}

  Value root;

  bool null() override { return Add({}); }
  bool boolean(bool value) override {
    Value v;
    v.kind = Value::kBool;
    v.number = value;
    return Add(std::move(v));
  }
  bool number_integer(number_integer_t value) override { return AddNumber(double(value)); }
  bool number_unsigned(number_unsigned_t value) override { return AddNumber(double(value)); }
  bool number_float(number_float_t value, const string_t&) override { return AddNumber(value); }
  bool string(string_t& value) override {
    Value v;
    v.kind = Value::kString;
    v.string = std::move(value);
    return Add(std::move(v));
  }
  bool binary(binary_t&) override { return false; }  // does not occur in JSON text
  bool start_object(std::size_t) override { return Open(Value::kObject); }
  bool start_array(std::size_t) override { return Open(Value::kArray); }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool key(string_t& name) override {
    if (name.size() > JsonNode::kMostText) {
      FailAt(file_, position_.line,
             "a field's name has " + std::to_string(name.size()) + " bytes; fix it");
    }
    if (!names_.back().insert(name).second) {
      FailAt(file_, position_.line, name + ": is given twice; keep one of the two");
    }
    open_.back()->members.emplace_back().name = std::move(name);
    return true;
  }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception& error) override {
    const auto end = text_.begin() + std::min(position, text_.size());
    const int line = 1 + static_cast<int>(std::count(text_.begin(), end, '\n'));
    std::string why = error.what();
    const std::size_t start = why.rfind("; last read");
    const std::size_t detail = why.find(": ", why.find(']'));
    why = detail == std::string::npos ? why : why.substr(detail + 2, start - detail - 2);
    FailAt(file_, line, "this is not JSON (" + why + "); fix it at or just before this line");
  }

 private:
  bool AddNumber(double value) {
    Value v;
    v.kind = Value::kNumber;
    v.number = value;
    return Add(std::move(v));
  }
  Value* Place(Value value) {
    if (++values_ > kMaxValues) {
      FailAt(
          file_, position_.line,
          "has more than " + std::to_string(kMaxValues) + " values; no scene or mesh needs them");
    }
    value.line = position_.line;
    // The parser notices the end of a number only at the next character, which may be the
    // line's end.
    if (value.kind == Value::kNumber && position_.at_line_end) --value.line;
    if (open_.empty()) {
      root = std::move(value);
      return &root;
    }
    Value& parent = *open_.back();
    if (parent.kind == Value::kArray) parent.members.emplace_back();
    Value& place = parent.members.back();
    value.name = std::move(place.name);
    place = std::move(value);
    return &place;
  }
  bool Add(Value value) {
    Place(std::move(value));
    return true;
  }
  bool Open(Value::Kind kind) {
    if (open_.size() >= kMaxDepth)
      FailAt(file_, position_.line, "lists are nested too deep; flatten them");
    Value v;
    v.kind = kind;
    open_.push_back(Place(std::move(v)));
    names_.emplace_back();
    return true;
  }
  bool Close() {
    open_.pop_back();
    names_.pop_back();
    return true;
  }

  const std::string& file_;
  std::string_view text_;
  const Position& position_;
  std::vector<Value*> open_;
  std::vector<std::unordered_set<std::string>> names_;  ///< of the members of each that is open
  std::size_t values_ = 0;
};

}  // namespace

JsonNode::JsonNode(std::shared_ptr<const Document> document, const Value* value, std::string path)
    : document_(std::move(document)), value_(value), path_(std::move(path)) {}

JsonNode JsonNode::Load(const std::string& file) {
  return Parse(ReadWholeFile(file, kMostBytes), file);
}

JsonNode JsonNode::Parse(std::string_view text, const std::string& file) {
  if (text.size() > kMostBytes) {
    throw Error(file + ": holds more than " + std::to_string(kMostBytes >> 20) +
                " MiB, the limit for such a file; check that it is the right one");
  }
  text = WithoutMark(text, file);
  auto document = std::make_shared<Document>();
  document->file = file;
  Position position;
  Builder builder(document->file, text, position);
  nlohmann::json::sax_parse(LineCounter(text.data(), &position),
                            LineCounter(text.data() + text.size(), &position), &builder,
                            nlohmann::json::input_format_t::json, true, true);
  document->root = std::move(builder.root);
  const Value* root = &document->root;
  return JsonNode(std::move(document), root, "");
}

std::string JsonNode::Where() const {
  return document_->file + ":" + std::to_string(value_->line) + (path_.empty() ? "" : ": ") + path_;
}

void JsonNode::Fail(const std::string& message) const {
  throw Error(Where() + ": " + message);
}

const Value& JsonNode::Expect(int kind, const char* what) const {
  if (value_->kind != kind) {
    Fail(std::string("is ") + KindName(value_->kind) + "; give " + what);
  }
  return *value_;
}

void JsonNode::AllowOnly(const std::vector<std::string_view>& fields) const {
  for (const Value& member : Expect(Value::kObject, "an object { ... }").members) {
    if (std::find(fields.begin(), fields.end(), member.name) != fields.end()) continue;
    Find(member.name)->Fail("there is no such field" + DidYouMeanOneOf(member.name, fields));
  }
}

std::optional<JsonNode> JsonNode::Find(std::string_view field) const {
  for (const Value& member : Expect(Value::kObject, "an object { ... }").members) {
    if (member.name != field) continue;
    return JsonNode(document_, &member, path_.empty() ? member.name : path_ + "." + member.name);
  }
  return std::nullopt;
}

std::vector<std::string> JsonNode::Fields() const {
  std::vector<std::string> names;
  for (const Value& member : Expect(Value::kObject, "an object { ... }").members) {
    names.push_back(member.name);
  }
  return names;
}

bool JsonNode::Has(std::string_view field) const {
  return Find(field).has_value();
}

JsonNode JsonNode::At(std::string_view field) const {
  if (auto node = Find(field)) return *node;
  Fail(std::string(field) + " is missing; add it");
}

std::vector<JsonNode> JsonNode::Items(std::size_t at_least, std::size_t at_most) const {
  const Value& list = Expect(Value::kArray, "a list [ ... ]");
  if (list.members.size() < at_least) {
    Fail("has " + std::to_string(list.members.size()) + " entries; give at least " +
         std::to_string(at_least));
  }
  if (list.members.size() > at_most) {
    Fail("has " + std::to_string(list.members.size()) + " entries; give at most " +
         std::to_string(at_most));
  }
  std::vector<JsonNode> items;
  for (const Value& value : list.members) {
    items.push_back(JsonNode(document_, &value, path_ + "[" + std::to_string(items.size()) + "]"));
  }
  return items;
}

std::string JsonNode::String() const {
  const Value& v = Expect(Value::kString, "a string");
  if (v.string.empty()) Fail("is empty; give a name");
  if (v.string.size() > kMostText) {
    Fail("has " + std::to_string(v.string.size()) + " bytes; give " + std::to_string(kMostText) +
         " at most");
  }
  return v.string;
}

std::string JsonNode::Text() const {
  return Expect(Value::kString, "a string").string;
}

std::string JsonNode::OneOf(const std::vector<std::string_view>& words) const {
  const std::string word = String();
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  Fail("\"" + word + "\" is not known; give one of " + Joined(words));
}

double JsonNode::Number(double min, double max) const {
  const double number = Expect(Value::kNumber, "a number").number;
  if (!(number >= min && number <= max)) {
    std::ostringstream message;
    message << number << " is not allowed; give ";
    if (std::isinf(max)) {
      message << "at least " << min;
    } else {
      message << "a number from " << min << " to " << max;
    }
    Fail(message.str());
  }
  return number;
}

double JsonNode::PositiveNumber() const {
  const double number = Number();
  if (!(number > 0.0)) Fail(std::to_string(number) + " is not allowed; give a number above 0");
  return number;
}

std::int64_t JsonNode::Integer(std::int64_t min, std::int64_t max) const {
  const double number = Number(double(min), double(max));
  if (number != std::floor(number)) {
    std::ostringstream message;
    message << number << " is not a whole number; give one";
    Fail(message.str());
  }
  return static_cast<std::int64_t>(number);
}

bool JsonNode::Boolean() const {
  return Expect(Value::kBool, "true or false").number != 0.0;
}

bool JsonNode::IsFalse() const {
  return value_->kind == Value::kBool && value_->number == 0.0;
}

bool JsonNode::IsObject() const {
  return value_->kind == Value::kObject;
}

bool JsonNode::IsString() const {
  return value_->kind == Value::kString;
}

Vec3 JsonNode::Vector(double most) const {
  const std::vector<JsonNode> items = Items();
  if (items.size() != 3) {
    Fail("has " + std::to_string(items.size()) + " entries; give three: [x, y, z]");
  }
  return {items[0].Number(-most, most), items[1].Number(-most, most), items[2].Number(-most, most)};
}

Pose JsonNode::ReadPose() const {
  // No server accepts a pose more than 100 m away; arithmetic overflows beyond some 1e300.
  constexpr double kFar_mm = 1e5, kMostTurns_deg = 1e5, kLongestAxis = 1e6;
  Pose pose;
  if (auto position = Find("position_mm")) pose.p = 1e-3 * position->Vector(kFar_mm);
  const auto rotation = Find("rotation_deg");
  const auto quaternion = Find("quaternion_wxyz");
  if (rotation && quaternion) {
    quaternion->Fail("the rotation is given twice; keep rotation_deg or quaternion_wxyz");
  }
  if (rotation) {
    rotation->AllowOnly({"axis", "angle"});
    const Vec3 axis = rotation->At("axis").Vector(kLongestAxis);
    const double length = std::sqrt(axis.squaredNorm());
    if (!(length > 1e-9)) rotation->At("axis").Fail("has length 0; give a direction");
    constexpr double kDegree = 3.14159265358979323846 / 180.0;
    pose.q = RotationExp(rotation->At("angle").Number(-kMostTurns_deg, kMostTurns_deg) * kDegree /
                         length * axis);
  } else if (quaternion) {
    const std::vector<JsonNode> wxyz = quaternion->Items();
    if (wxyz.size() != 4) quaternion->Fail("give four numbers: [w, x, y, z]");
    pose.q = Quat(wxyz[0].Number(), wxyz[1].Number(), wxyz[2].Number(), wxyz[3].Number());
    const double norm = std::sqrt(pose.q.squaredNorm());
    if (!(std::abs(norm - 1.0) < 1e-3)) {
      quaternion->Fail("has length " + std::to_string(norm) + "; give a unit quaternion");
    }
    pose.q.coeffs() /= norm;
  }
  return pose;
}

}  // namespace palpate
