#include "scenes/importer/far_off.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace palpate {
namespace {

constexpr std::string_view kBlank = " \t\r\n\v\f";

/// Copies a text word by word, with what stands between, and moves some of its numbers.
class Copy {
 public:
  explicit Copy(std::string_view text) : rest_(text) { out_.reserve(text.size()); }

  /// The next word, which is not copied yet; empty at the end.
  std::string_view Word() {
    const std::size_t begin = std::min(rest_.find_first_not_of(kBlank), rest_.size());
    out_.append(rest_.substr(0, begin));
    rest_.remove_prefix(begin);
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlank));
    rest_.remove_prefix(word.size());
    return word;
  }
  void Keep(std::string_view words) { out_.append(words); }
  std::string_view Line() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size() - 1) + 1;
    const std::string_view line = rest_.substr(0, rest_.empty() ? 0 : end);
    rest_.remove_prefix(line.size());
    return line;
  }
  bool done() const { return rest_.empty(); }
  std::string_view& rest() { return rest_; }

  /// Moves a number along an axis; false where the word is none.
  bool Move(std::string_view word, int axis) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      return false;
    }
    std::array<char, 40> digits;
    const auto written = std::to_chars(digits.begin(), digits.end(), Moved(value, axis));
    out_.append(digits.begin(), written.ptr);
    return true;
  }
  double Moved(double value, int axis) {
    if (!known_[static_cast<std::size_t>(axis)]) {
      known_[static_cast<std::size_t>(axis)] = true;
      by_[axis] = std::trunc(value);
    }
    return value - by_[axis];
  }

  MovedText Done() && { return {std::move(out_), by_}; }

 private:
  std::string_view rest_;
  std::string out_;
  Vec3 by_ = Vec3::Zero();
  std::array<bool, 3> known_{};
};

/// "v x y z" a line.
std::optional<MovedText> MoveObj(std::string_view text) {
  Copy copy(text);
  while (!copy.done()) {
    const std::string_view line = copy.Line();
    if (!line.starts_with("v ") && !line.starts_with("v\t")) {
      copy.Keep(line);
      continue;
    }
    if (line.find('\\') != std::string_view::npos) return std::nullopt;  // goes on in the next
    const std::string_view rest_of_file = copy.rest();
    copy.rest() = line;
    copy.Keep(copy.Word());
    for (int axis = 0; axis < 3; ++axis) {
      if (!copy.Move(copy.Word(), axis)) return std::nullopt;
    }
    copy.Keep(copy.rest());
    copy.rest() = rest_of_file;
  }
  return std::move(copy).Done();
}

/// "vertex x y z" anywhere behind the first line, which may hold any words.
std::optional<MovedText> MoveStl(std::string_view text) {
  if (!text.starts_with("solid") || text.find("facet") == std::string_view::npos) {
    return std::nullopt;
  }
  Copy copy(text);
  copy.Keep(copy.Line());
  while (!copy.done()) {
    const std::string_view word = copy.Word();
    copy.Keep(word);
    if (word != "vertex") continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (!copy.Move(copy.Word(), axis)) return std::nullopt;
    }
  }
  return std::move(copy).Done();
}

/// The vertices of a PLY, where they are its first element and hold no lists.
struct PlyVertices {
  std::uint64_t count = 0;
  std::vector<std::string> types;
  std::array<int, 3> at{-1, -1, -1};  ///< which properties x, y and z are
  bool text = false, usual = true;
};

std::vector<std::string> WordsOf(std::string_view line) {
  std::vector<std::string> words;
  Copy copy(line);
  for (std::string_view word = copy.Word(); !word.empty(); word = copy.Word()) {
    words.emplace_back(word);
  }
  return words;
}

/// Copies the header, as it is.
PlyVertices ReadPlyHeader(Copy& copy) {
  PlyVertices vertices;
  std::size_t elements = 0;
  while (!copy.done()) {
    const std::string_view line = copy.Line();
    copy.Keep(line);
    const std::vector<std::string> words = WordsOf(line);
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() > 1) {
      vertices.text = words[1] == "ascii";
      vertices.usual &= vertices.text || words[1] == "binary_little_endian";
    }
    if (words[0] == "element" && words.size() > 2 && elements++ == 0) {
      vertices.usual &= words[1] == "vertex";
      const char* const digits = words[2].data();
      std::from_chars(digits, digits + words[2].size(), vertices.count);
    }
    if (words[0] != "property" || elements != 1) continue;
    vertices.usual &= words.size() == 3;
    if (!vertices.usual) break;
    for (int axis = 0; axis < 3; ++axis) {
      if (words[2] == std::string(1, static_cast<char>('x' + axis))) {
        vertices.at[static_cast<std::size_t>(axis)] = static_cast<int>(vertices.types.size());
      }
    }
    vertices.types.push_back(words[1]);
  }
  for (const int at : vertices.at) vertices.usual &= at >= 0;
  return vertices;
}

std::size_t PlyBytes(const std::string& type) {
  if (type == "double" || type == "float64") return 8;
  if (type.ends_with("8") || type.ends_with("char")) return 1;
  return type.ends_with("16") || type.ends_with("short") ? 2 : 4;
}

std::optional<MovedText> MovePly(std::string_view text) {
  Copy copy(text);
  const PlyVertices vertices = ReadPlyHeader(copy);
  if (!vertices.usual) return std::nullopt;
  const auto axis_of = [&](std::size_t property) {
    return std::ranges::find(vertices.at, static_cast<int>(property)) - vertices.at.begin();
  };
  for (std::uint64_t v = 0; v < vertices.count; ++v) {
    for (std::size_t p = 0; p < vertices.types.size(); ++p) {
      const int axis = static_cast<int>(axis_of(p));
      if (vertices.text) {
        const std::string_view word = copy.Word();
        if (word.empty()) return std::nullopt;
        if (axis == 3) copy.Keep(word);
        if (axis < 3 && !copy.Move(word, axis)) return std::nullopt;
        continue;
      }
      const std::size_t bytes = PlyBytes(vertices.types[p]);
      if (bytes > copy.rest().size() || (axis < 3 && bytes != 8)) return std::nullopt;
      if (axis == 3) {
        copy.Keep(copy.rest().substr(0, bytes));
      } else {
        double value = 0.0;
        std::memcpy(&value, copy.rest().data(), sizeof value);
        if (!std::isfinite(value)) return std::nullopt;
        const auto moved = std::bit_cast<std::array<char, 8>>(copy.Moved(value, axis));
        copy.Keep({moved.data(), moved.size()});
      }
      copy.rest().remove_prefix(bytes);
    }
  }
  copy.Keep(copy.rest());
  return std::move(copy).Done();
}

}  // namespace

std::optional<MovedText> MoveToOrigin(const std::string& format, std::string_view text) {
  if (format == "obj") return MoveObj(text);
  if (format == "stl") return MoveStl(text);
  if (format == "ply") return MovePly(text);
  return std::nullopt;
}

}  // namespace palpate
