#include "scenes/importer/declared_size.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <vector>

#include "common/error.h"

namespace palpate {
namespace {

constexpr const char* kExportAgain = "; the file is cut short or damaged, export or copy it again";

[[noreturn]] void Refuse(const std::string& why) {
  throw Error(why + kExportAgain);
}

std::uint32_t NumberAt(std::string_view text, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, text.data() + at, sizeof number);
  return number;
}

/// Takes the next word, and what stands before it, off the text; empty at the end.
std::string_view NextWord(std::string_view& text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlank));
  text.remove_prefix(word.size());
  return word;
}

template <class T>
std::optional<T> NumberOf(std::string_view word) {
  T number{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return number;
}

// --- PLY ---

/// Bytes of a PLY type; 0 where there is no such type.
std::size_t BytesOf(std::string_view type) {
  static const std::map<std::string_view, std::size_t> kBytes{
      {"char", 1},   {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2},  {"uint16", 2},  {"int", 4},    {"uint", 4},   {"float", 4}, {"int32", 4},
      {"uint32", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto it = kBytes.find(type);
  return it == kBytes.end() ? 0 : it->second;
}

struct Property {
  std::size_t count_bytes = 0;  ///< of a list's count; 0: it is no list
  std::size_t bytes = 0;        ///< of a value
};
struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

class Ply {
 public:
  explicit Ply(std::string_view text) : rest_(text) { ReadHeader(); }

  void CheckBody() {
    for (const Element& element : elements_) {
      // Each of the others takes a byte at least, so the walk ends with the file.
      if (element.properties.empty() && element.count > 0) {
        Refuse("element " + element.name + " has no properties");
      }
      for (std::uint64_t i = 0; i < element.count; ++i) {
        if (Skip(element)) continue;
        Refuse("it declares " + std::to_string(element.count) + " elements \"" + element.name +
               "\" (faces of a mesh, say), and " + std::to_string(i) + " are there");
      }
    }
  }

 private:
  std::string_view Line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) Refuse("its PLY header has no end");
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return line;
  }

  void ReadHeader() {
    std::string_view first = Line();
    if (NextWord(first) != "ply") Refuse("it is no PLY");
    for (;;) {
      std::string_view line = Line();
      const std::string_view what = NextWord(line);
      if (what == "end_header") break;
      if (what == "format") ReadFormat(NextWord(line));
      if (what == "element") ReadElement(line);
      if (what == "property") ReadProperty(line);
    }
    if (!known_format_) Refuse("its PLY header names no format");
  }

  void ReadFormat(std::string_view name) {
    ascii_ = name == "ascii";
    big_endian_ = name == "binary_big_endian";
    known_format_ = ascii_ || big_endian_ || name == "binary_little_endian";
  }

  void ReadElement(std::string_view line) {
    Element element;
    element.name = NextWord(line);
    const auto count = NumberOf<std::uint64_t>(NextWord(line));
    if (!count) Refuse("its PLY header does not say how many \"" + element.name + "\" there are");
    element.count = *count;
    elements_.push_back(std::move(element));
  }

  void ReadProperty(std::string_view line) {
    Property property;
    std::string_view type = NextWord(line);
    const bool list = type == "list";
    if (list) {
      property.count_bytes = BytesOf(NextWord(line));
      type = NextWord(line);
    }
    property.bytes = BytesOf(type);
    if (property.bytes == 0 || (list && property.count_bytes == 0) || elements_.empty()) {
      Refuse("its PLY header has a property of no known type");
    }
    elements_.back().properties.push_back(property);
  }

  /// Steps over one element; false where the file ends before.
  bool Skip(const Element& element) {
    for (const Property& property : element.properties) {
      std::uint64_t values = 1;
      if (property.count_bytes > 0) {
        const auto count = ReadCount(property.count_bytes);
        if (!count) return false;
        values = *count;
      }
      if (ascii_) {
        for (; values > 0; --values) {
          if (NextWord(rest_).empty()) return false;
        }
      } else {
        if (values > rest_.size() / property.bytes) return false;
        rest_.remove_prefix(values * property.bytes);
      }
    }
    return true;
  }

  std::optional<std::uint64_t> ReadCount(std::size_t bytes) {
    if (ascii_) return NumberOf<std::uint64_t>(NextWord(rest_));
    if (bytes > rest_.size()) return std::nullopt;
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const auto byte = static_cast<unsigned char>(rest_[big_endian_ ? i : bytes - 1 - i]);
      count = count << 8 | byte;
    }
    rest_.remove_prefix(bytes);
    return count;
  }

  std::string_view rest_;
  bool ascii_ = false, big_endian_ = false, known_format_ = false;
  std::vector<Element> elements_;
};

// --- the others ---

/// A binary STL begins with 80 bytes of anything and its count of facets, 50 bytes each.
void CheckStl(std::string_view text) {
  constexpr std::size_t kHeader = 84, kFacet = 50;
  if (text.size() >= kHeader) {
    const std::size_t declared = NumberAt(text, kHeader - 4);
    const std::size_t found = (text.size() - kHeader) / kFacet;
    if (declared <= found && text.size() - kHeader - declared * kFacet < kFacet) return;
    if (!text.starts_with("solid")) {
      Refuse("it declares " + std::to_string(declared) + " facets, and " + std::to_string(found) +
             " are there");
    }
  }
  if (!text.starts_with("solid")) Refuse("it is no STL");
  std::size_t facets = 0, ended = 0;
  std::string_view last;
  for (std::string_view rest = text, word = NextWord(rest); !word.empty(); word = NextWord(rest)) {
    facets += word == "facet";
    ended += word == "endfacet";
    if (word == "endsolid") last = word;
    if (word == "facet") last = {};
  }
  if (facets != ended) {
    Refuse("it begins " + std::to_string(facets) + " facets and ends " + std::to_string(ended));
  }
  if (last.empty()) {
    Refuse("its solid has no end (endsolid) after " + std::to_string(facets) + " facets");
  }
}

/// A .glb begins with magic, version and length, and is chunks of length, type and contents.
void CheckGlb(std::string_view text) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  if (text.size() < kHeader + kChunkHeader || !text.starts_with("glTF")) Refuse("it is no .glb");
  if (const std::uint32_t version = NumberAt(text, 4); version != 2) {
    throw Error("it is of glTF version " + std::to_string(version) + "; export it as glTF 2.0");
  }
  const std::size_t declared = NumberAt(text, 8);
  if (declared != text.size()) {
    Refuse("it declares " + std::to_string(declared) + " bytes, and " +
           std::to_string(text.size()) + " are there");
  }
  for (std::size_t at = kHeader; at < text.size();) {
    const std::size_t left = text.size() - at;
    if (left < kChunkHeader || NumberAt(text, at) > left - kChunkHeader) {
      Refuse("its chunks do not add up to its length");
    }
    at += kChunkHeader + NumberAt(text, at);
  }
}

/// A 3DS is one chunk, of type 0x4d4d and with its length.
void Check3ds(std::string_view text) {
  constexpr std::size_t kHeader = 6;
  if (text.size() < kHeader || !text.starts_with("MM")) Refuse("it is no 3DS");
  if (const std::size_t declared = NumberAt(text, 2); declared > text.size()) {
    Refuse("it declares " + std::to_string(declared) + " bytes, and " +
           std::to_string(text.size()) + " are there");
  }
}

}  // namespace

void CheckDeclaredSize(const std::string& format, std::string_view text) {
  if (format == "ply") Ply(text).CheckBody();
  if (format == "stl") CheckStl(text);
  if (format == "glb") CheckGlb(text);
  if (format == "3ds") Check3ds(text);
}

}  // namespace palpate
