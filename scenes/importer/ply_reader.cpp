#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/text/number_of.h"
#include "common/text/quoted.h"
#include "scenes/importer/mesh_text.h"
#include "scenes/importer/polygons.h"
#include "scenes/importer/raw_number.h"
#include "scenes/importer/readers.h"

namespace palpate {
namespace {

/// The names of kRawTypes.
constexpr std::pair<std::string_view, std::string_view> kTypeNames[] = {
    {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
    {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
constexpr const RawType* kFloat = &kRawTypes[6];

[[noreturn]] void Refuse(const std::string& why) {
  throw Error(why + kExportAgain);
}

/// The meaning of a property for a mesh.
enum class Role { kNone, kX, kY, kZ, kCorners };

struct Property {
  Role role = Role::kNone;
  const RawType* count = nullptr;  ///< type of a list's length; null: no list
  const RawType* type = kFloat;
};
struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
  bool Has(Role role) const {
    return std::ranges::any_of(properties, [&](const Property& p) { return p.role == role; });
  }
};

/// Reads faces and triangle strips, in text or in binary of either byte order.
class Ply {
 public:
  explicit Ply(std::string_view text) : text_(text) {
    ReadHeader();
    // If lines end with CR alone, a LF after the last one is the first byte of the body.
    const std::size_t end = text.find_first_of("\r\n");
    const bool cr_alone =
        end != std::string_view::npos && text[end] == '\r' && text[end + 1] != '\n';
    body_ = text_.rest();
    if (cr_alone && body_.data()[-1] == '\n') body_ = {body_.data() - 1, body_.size() + 1};
  }

  FileContents Read() && {
    for (const Element& element : elements_) {
      // All other elements take at least a byte each, so the loop ends with the file.
      if (element.properties.empty() && element.count > 0) {
        Refuse("element " + Quoted(element.name) + " has no properties");
      }
      for (std::uint64_t i = 0; i < element.count; ++i) {
        if (ReadElement(element)) continue;
        throw Error("it declares " + std::to_string(element.count) + " elements " +
                    Quoted(element.name) + " (such as faces), but " + std::to_string(i) +
                    " are present; the file is truncated or damaged: export or copy it again");
      }
    }
    FileContents file{TrianglesOf(std::move(mesh_))};
    if (single_) file.step = kSingleStep * FarthestOf(file.read.mesh);
    return file;
  }

 private:
  // --- header ---

  void ReadHeader() {
    if (text_.Line() != "ply") Refuse("its PLY header does not begin with \"ply\"");
    for (;;) {
      if (text_.done()) Refuse("its PLY header has no end");
      const std::string_view line = text_.Line();
      if (line == "end_header") break;
      ReadHeaderLine(line);
    }
    if (!known_format_) Refuse("its PLY header names no format");
    CheckElements();
  }

  void ReadHeaderLine(std::string_view line) {
    MeshText words(line);
    const std::string_view what = words.Word();
    if (what == "format") {
      const std::string_view name = words.Word();
      ascii_ = name == "ascii";
      big_endian_ = name == "binary_big_endian";
      known_format_ = ascii_ || big_endian_ || name == "binary_little_endian";
    } else if (what == "element") {
      Element element;
      element.name = words.Word();
      const auto count = NumberOf<decltype(element.count)>(words.Word());
      if (!count) {
        Refuse("its PLY header does not say how many " + Quoted(element.name) + " there are");
      }
      element.count = *count;
      elements_.push_back(std::move(element));
    } else if (what == "property") {
      ReadProperty(words);
    } else if (what != "comment" && what != "obj_info" && !what.empty()) {
      Refuse("its PLY header has a line that begins with " + Quoted(what));
    }
  }

  static const RawType* TypeOf(std::string_view name) {
    for (std::size_t i = 0; i < std::size(kTypeNames); ++i) {
      if (name == kTypeNames[i].first || name == kTypeNames[i].second) return &kRawTypes[i];
    }
    Refuse("its PLY header has a property of an unknown type, " + Quoted(name));
  }

  void ReadProperty(MeshText& words) {
    if (elements_.empty()) Refuse("its PLY header has a property outside an element");
    Element& element = elements_.back();
    Property property;
    std::string_view type = words.Word();
    if (type == "list") {
      property.count = TypeOf(words.Word());
      type = words.Word();
    }
    property.type = TypeOf(type);
    const std::string_view name = words.Word();
    if (property.count && (element.name == "face" || element.name == "tristrips") &&
        (name == "vertex_indices" || name == "vertex_index")) {
      property.role = Role::kCorners;
    } else if (!property.count && element.name == "vertex" && name.size() == 1 && name >= "x" &&
               name <= "z") {
      property.role = static_cast<Role>(static_cast<int>(Role::kX) + (name[0] - 'x'));
      single_ |= property.type == kFloat && !ascii_;
    }
    element.properties.push_back(property);
  }

  void CheckElements() const {
    bool faces = false;
    for (const Element& element : elements_) {
      const bool face = element.name == "face" || element.name == "tristrips";
      faces |= face;
      if (face && !element.Has(Role::kCorners)) {
        Refuse("its " + element.name + " has no list \"vertex_indices\"");
      }
      for (const Role role : {Role::kX, Role::kY, Role::kZ}) {
        if (element.name == "vertex" && !element.Has(role))
          Refuse("its vertices have no x, y or z");
      }
    }
    if (!faces) {
      throw Error("it has points but no faces; make a surface of them in a mesh editor");
    }
  }

  // --- body ---

  /// Returns false if the file ends before.
  bool ReadElement(const Element& element) {
    Vec3 v = Vec3::Zero();
    for (const Property& property : element.properties) {
      double count = 1.0;
      if (property.count && !Next(*property.count, count)) return false;
      if (!(count >= 0.0) || count != std::floor(count)) {
        Complain(element.name + " has a list of " + std::to_string(count) + " values");
      }
      corners_.clear();
      for (; count > 0.0; --count) {
        double value = 0.0;
        if (!Next(*property.type, value)) return false;
        if (property.role == Role::kCorners) {
          AddCorner(element, value);
        } else if (property.role != Role::kNone) {
          v[static_cast<int>(property.role) - static_cast<int>(Role::kX)] = value;
        }
      }
      if (property.role == Role::kCorners) EndFace(element);
    }
    if (element.name == "vertex") mesh_.vertices.push_back(v);
    return true;
  }

  void AddCorner(const Element& element, double value) {
    if (value == -1.0 && element.name == "tristrips") return EndFace(element);
    if (!(value >= 0.0) || value > std::numeric_limits<std::uint32_t>::max() ||
        value != std::floor(value)) {
      Complain(element.name + " names the vertex " + std::to_string(value));
    }
    corners_.push_back(static_cast<std::uint32_t>(value));
  }

  /// Ends a face.  In a strip every second triangle is turned, and one with a repeated corner
  /// only leads on.
  void EndFace(const Element& element) {
    if (element.name == "face") return mesh_.Add(corners_);
    for (std::size_t i = 0; i + 2 < corners_.size(); ++i) {
      std::array<std::uint32_t, 3> triangle{corners_[i], corners_[i + 1], corners_[i + 2]};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
        continue;
      }
      if (i % 2 == 1) std::swap(triangle[0], triangle[1]);
      mesh_.Add(triangle);
    }
    corners_.clear();
  }

  bool Next(const RawType& type, double& value) {
    if (ascii_) {
      const std::string_view word = text_.Word();
      if (word.empty()) return false;
      if (!ReadNumber(word, value)) Complain(Quoted(word) + " is not a number");
      return true;
    }
    if (type.bytes > body_.size()) return false;
    std::array<char, 8> raw{};
    std::copy_n(body_.data(), type.bytes, raw.data());
    if (big_endian_) {
      std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(type.bytes));
    }
    body_.remove_prefix(type.bytes);
    value = type.read(raw.data());
    return true;
  }

  [[noreturn]] void Complain(const std::string& why) const {
    if (ascii_) text_.Fail(why);
    Refuse(why);
  }

  MeshText text_;
  std::string_view body_;
  bool ascii_ = false, big_endian_ = false, known_format_ = false;
  bool single_ = false;
  std::vector<Element> elements_;
  Polygons mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

FileContents ReadPly(const std::string&, std::string_view text) {
  return Ply(text).Read();
}

}  // namespace palpate
