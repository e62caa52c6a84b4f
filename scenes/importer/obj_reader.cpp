#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/text/lower_case.h"
#include "common/text/quoted.h"
#include "scenes/importer/mesh_text.h"
#include "scenes/importer/polygons.h"
#include "scenes/importer/readers.h"

namespace palpate {
namespace {

/// Reads Wavefront's OBJ as other programs write it: any blanks before and between words, any line
/// ends, colours or a weight after a vertex.  Rejects free-form surfaces, without which the body
/// would be another.
class Obj {
 public:
  explicit Obj(std::string_view text) : text_(text) {}

  ImportedMesh Read() && {
    for (; !text_.done(); text_.EndLine()) ReadLine(LowerCase(text_.WordOfLine()));
    Close(object_);
    Close(group_);
    ImportedMesh read = TrianglesOf(std::move(mesh_));
    NumberByUse(read.mesh);
    return read;
  }

 private:
  void ReadLine(const std::string& what) {
    if (what == "v") {
      Vec3 v;
      for (double& number : v) number = ReadCoordinate();
      mesh_.vertices.push_back(v);
    } else if (what == "f" || what == "fo") {  // fo: its name before version 3
      ReadFace();
    } else if (what == "o") {
      Open(object_);
    } else if (what == "g") {
      Open(group_);
    } else if (what == "surf" || what == "call") {
      text_.Fail("it holds " +
                 std::string(what == "surf" ? "a free-form surface" : "another file") + " (" +
                 what + "), which is not read; export polygons, all in one file");
    }
  }

  double ReadCoordinate() {
    const std::string_view word = text_.WordOfLine();
    double value = 0.0;
    if (word.empty()) text_.Fail("a vertex has fewer than three coordinates");
    if (!ReadNumber(word, value)) text_.Fail(Quoted(word) + " is not a number");
    return value;
  }

  /// Reads "1", "1/2", "1//3" or "1/2/3" for each corner; indices count from 1, negative ones
  /// from the end.
  void ReadFace() {
    face_.clear();
    for (std::string_view word = text_.WordOfLine(); !word.empty(); word = text_.WordOfLine()) {
      const std::string_view digits = word.substr(0, word.find('/'));
      const auto vertices = static_cast<std::int64_t>(mesh_.vertices.size());
      std::int64_t number = 0;
      const auto [end, error] = std::from_chars(digits.data() + digits.starts_with('+'),
                                                digits.data() + digits.size(), number);
      const std::int64_t v = number < 0 ? vertices + number : number - 1;
      if (error != std::errc() || end != digits.data() + digits.size() || v < 0 ||
          v > std::numeric_limits<std::uint32_t>::max()) {
        text_.Fail(Quoted(word) + " is not a corner of a face");
      }
      face_.push_back(static_cast<std::uint32_t>(v));
    }
    if (face_.size() >= 3) mesh_.Add(face_);
  }

  /// Ends an object or a group; both stay open until the next of their kind.
  void Close(MeshGroup& part) {
    part.end = mesh_.size();
    if (!part.name.empty() && part.end > part.begin) mesh_.groups.push_back(part);
  }
  void Open(MeshGroup& part) {
    Close(part);
    part.begin = mesh_.size();
    part.name.clear();
    for (std::string_view word = text_.WordOfLine(); !word.empty(); word = text_.WordOfLine()) {
      if (!part.name.empty()) part.name += ' ';
      part.name += word;
    }
  }

  /// Numbers vertices in the order of first use, and drops unused ones, which may hold colours.
  static void NumberByUse(TriangleMesh& mesh) {
    constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
    std::vector<Vec3> used;
    for (auto& triangle : mesh.triangles) {
      for (std::uint32_t& v : triangle) {
        if (number[v] == kNone) {
          number[v] = static_cast<std::uint32_t>(used.size());
          used.push_back(mesh.vertices[v]);
        }
        v = number[v];
      }
    }
    mesh.vertices = std::move(used);
  }

  MeshText text_;
  Polygons mesh_;
  std::vector<std::uint32_t> face_;
  MeshGroup object_, group_;
};

}  // namespace

FileContents ReadObj(const std::string&, std::string_view text) {
  return {Obj(text).Read()};
}

}  // namespace palpate
