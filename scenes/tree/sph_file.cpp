#include "scenes/tree/sph_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "scenes/tree/tree_error.h"

namespace palpate {
namespace {

constexpr std::size_t kShortestLine = 8;  // "0 0 0 1\n"
constexpr double kFurthest = 1e6;         // [m]: a greater distance means a wrong unit

// at some 48 bytes each the file can be read again
constexpr std::size_t kMostSlots = kLargestSphFile / 48;

/// Returns the same as isspace in the C locale.
bool IsBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Reads the non-blank lines of a text, and the numbers in them.
class LineReader {
 public:
  LineReader(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// Goes to the next line that is not blank; returns false at the end.
  bool Next() {
    while (!text_.empty()) {
      ++number_;
      const std::size_t end = text_.find('\n');
      line_ = text_.substr(0, end);
      text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
      while (!line_.empty() && IsBlank(line_.front())) line_.remove_prefix(1);
      if (!line_.empty()) return true;
    }
    return false;
  }

  /// Reads the next word of the line as a number; nullopt if there is no word, or no number.
  template <class Number>
  std::optional<Number> Take() {
    while (!line_.empty() && IsBlank(line_.front())) line_.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(line_.data(), line_.data() + line_.size(), value);
    const auto length = static_cast<std::size_t>(end - line_.data());
    if (error != std::errc() || (length < line_.size() && !IsBlank(line_[length]))) {
      return std::nullopt;
    }
    line_.remove_prefix(length);
    return value;
  }

  bool AtEndOfLine() {
    while (!line_.empty() && IsBlank(line_.front())) line_.remove_prefix(1);
    return line_.empty();
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(fmt::format("{}:{}: {}", file_, std::max(number_, 1), message));
  }

 private:
  std::string_view text_, line_;
  const std::string& file_;
  int number_ = 0;
};

/// Returns the number of slots of a tree; nullopt if there are more than `most`.
std::optional<std::size_t> NodesOf(int levels, int degree, std::size_t most) {
  std::size_t row = 1, nodes = 1;
  for (int l = 1; l < levels; ++l) {
    if (row > most / static_cast<std::size_t>(degree)) return std::nullopt;
    row *= static_cast<std::size_t>(degree);
    nodes += row;
    if (nodes > most) return std::nullopt;
  }
  return nodes <= most ? std::optional(nodes) : std::nullopt;
}

SphTree ReadHeader(LineReader& lines, std::size_t bytes) {
  SphTree tree;
  const char* const kNoTree =
      "does not begin with \"levels degree\", two whole numbers, as a .sph file does; give the "
      ".sph file that the Sphere-Tree Construction Toolkit has written";
  if (!lines.Next()) lines.Fail(kNoTree);
  const auto levels = lines.Take<int>();
  const auto degree = lines.Take<int>();
  if (!levels || !degree || !lines.AtEndOfLine()) lines.Fail(kNoTree);
  if (*levels < 1 || *levels > kMaxSphLevels) {
    lines.Fail(
        fmt::format("{} levels are not possible; there may be 1 to {}", *levels, kMaxSphLevels));
  }
  if (*degree < 1)
    lines.Fail(fmt::format("a degree of {} is not possible; it is 1 or more", *degree));
  // Check this before allocating: every node has a line.
  const auto nodes = NodesOf(*levels, *degree, bytes / kShortestLine + 1);
  if (!nodes) {
    lines.Fail(
        fmt::format("declares {} levels of degree {}, which are more nodes than its {} bytes can "
                    "hold; it is truncated or damaged: write it again",
                    *levels, *degree, bytes));
  }
  tree.levels = *levels;
  tree.degree = *degree;
  tree.nodes.resize(*nodes);
  return tree;
}

SphTree::Node ReadNode(LineReader& lines, double metres_per_unit) {
  double number[4];
  for (double& n : number) {
    const auto read = lines.Take<double>();
    if (!read || !std::isfinite(*read)) {
      lines.Fail(
          "is not a node: \"x y z radius importance\", all finite; the file is truncated or "
          "damaged: write it again");
    }
    n = *read * metres_per_unit;
    if (!(std::abs(n) <= kFurthest)) {
      lines.Fail(fmt::format("{} is more than 1000 km; give the unit of the file", *read));
    }
  }
  SphTree::Node node{{{number[0], number[1], number[2]}, number[3]}};
  if (lines.AtEndOfLine()) return node;
  const auto importance = lines.Take<double>();
  if (!importance || !std::isfinite(*importance)) {
    lines.Fail("has no finite number after x y z radius; the file is damaged: write it again");
  }
  node.importance = *importance;
  return node;
}

/// Returns the index of each row's first node, and of the end of the last row.
std::vector<std::size_t> RowsOf(const SphTree& tree) {
  std::vector<std::size_t> rows{0, 1};
  for (int l = 1; l < tree.levels; ++l) {
    rows.push_back(rows.back() +
                   (rows.back() - rows[rows.size() - 2]) * static_cast<std::size_t>(tree.degree));
  }
  return rows;
}

}  // namespace

SphTree ParseSph(std::string_view text, const std::string& file, double metres_per_unit) {
  LineReader lines(text, file);
  SphTree tree = ReadHeader(lines, text.size());
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    if (!lines.Next()) {
      lines.Fail(
          fmt::format("ends after {} of the {} nodes that its first line declares; it is "
                      "truncated: write it again",
                      i, tree.nodes.size()));
    }
    tree.nodes[i] = ReadNode(lines, metres_per_unit);
  }
  if (std::none_of(tree.nodes.begin(), tree.nodes.end(), [](const auto& n) { return n.used(); })) {
    lines.Fail("no node has a radius above 0; give a file with a tree");
  }
  return tree;
}

std::string ReadSphText(const std::string& file) {
  return ReadWholeFile(file, kLargestSphFile);
}

SphTree ReadSph(const std::string& file, double metres_per_unit) {
  return ParseSph(ReadSphText(file), file, metres_per_unit);
}

std::string ToSph(const SphTree& tree, double metres_per_unit) {
  std::string text = fmt::format("{} {}\n", tree.levels, tree.degree);
  for (const SphTree::Node& node : tree.nodes) {
    const Vec3 p = node.ball.centre / metres_per_unit;
    // Adding 0 turns -0 into 0.
    fmt::format_to(std::back_inserter(text), "{:.6f} {:.6f} {:.6f} {:.6f} {:.6f}\n", p.x() + 0.0,
                   p.y() + 0.0, p.z() + 0.0, node.ball.radius / metres_per_unit, node.importance);
  }
  return text;
}

SphTree SphOf(const SphereTree& tree, int levels) {
  SphTree sph;
  sph.degree = kTreeArity;
  const int below = levels > 0 ? std::min(levels, tree.levels()) : tree.levels();
  sph.levels = below + 1;
  const auto slots = NodesOf(sph.levels, sph.degree, kMostSlots);
  if (!slots) {
    throw Error(fmt::format(
        "a .sph file of {} levels of degree {} would have more than {} lines; give fewer levels",
        sph.levels, sph.degree, kMostSlots));
  }
  sph.nodes.reserve(*slots);
  const std::vector<Sphere> leaves = BallsByLevel(tree).back();
  const SphTree::Node unused{{Vec3::Zero(), -1.0}};
  sph.nodes.push_back({EnclosingSphere(leaves)});
  std::vector<std::int32_t> packets{0};  // for each slot of the row; < 0: none
  for (int l = 0; l < below; ++l) {
    std::vector<std::int32_t> children;
    for (const std::int32_t at : packets) {
      for (int lane = 0; lane < kTreeArity; ++lane) {
        const SpherePacket* packet =
            at < 0 ? nullptr : &tree.level(l)[static_cast<std::size_t>(at)];
        const std::int32_t child = packet == nullptr ? -1 : packet->child[lane];
        children.push_back(child);
        if (child < 0) {
          sph.nodes.push_back(unused);
        } else if (l + 1 == tree.levels()) {
          sph.nodes.push_back({leaves[static_cast<std::size_t>(child)]});
        } else {
          sph.nodes.push_back({{Vec3(packet->x[lane], packet->y[lane], packet->z[lane]),
                                double(packet->radius[lane])}});
        }
      }
    }
    packets = std::move(children);
  }
  return sph;
}

std::vector<Sphere> BallsOfLevel(const SphTree& tree, int level) {
  const std::vector<std::size_t> rows = RowsOf(tree);
  std::vector<Sphere> balls;
  const auto row = static_cast<std::size_t>(level) - 1;
  const auto degree = static_cast<std::size_t>(tree.degree);
  for (std::size_t r = 0; r <= row; ++r) {
    for (std::size_t i = rows[r]; i < rows[r + 1]; ++i) {
      if (!tree.nodes[i].used()) continue;
      const auto children = tree.nodes.begin() + static_cast<std::ptrdiff_t>(i * degree + 1);
      if (r == row || std::none_of(children, children + tree.degree,
                                   [](const auto& child) { return child.used(); })) {
        balls.push_back(tree.nodes[i].ball);
      }
    }
  }
  return balls;
}

}  // namespace palpate
