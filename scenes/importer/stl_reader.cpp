#include <cstdint>
#include <cstring>
#include <utility>

#include <Eigen/Geometry>

#include "common/error.h"
#include "common/text/lower_case.h"
#include "common/text/quoted.h"
#include "scenes/importer/mesh_text.h"
#include "scenes/importer/polygons.h"
#include "scenes/importer/readers.h"

namespace palpate {
namespace {

constexpr std::size_t kHeader = 84, kFacet = 50;

/// Returns whether an STL is binary.  A binary one begins with 80 arbitrary bytes, possibly
/// "solid", and the count of facets.  In a file that may be read (kLargestMeshFile) the count is
/// below 43 million, so its last byte is 2 or less, which no byte of a text is.
bool IsBinary(std::string_view bytes) {
  return bytes.size() >= kHeader && static_cast<unsigned char>(bytes[kHeader - 1]) <= 2;
}

/// Returns a facet's corners.  A facet is its normal and three corners, of three floats each,
/// and two bytes.
std::array<Vec3, 3> CornersOf(std::string_view bytes, std::size_t facet) {
  std::array<Vec3, 3> corners;
  for (std::size_t c = 0; c < 3; ++c) {
    Eigen::Vector3f p;
    std::memcpy(p.data(), bytes.data() + kHeader + facet * kFacet + 12 * (c + 1), 12);
    corners[c] = p.cast<double>();
  }
  return corners;
}

FileContents ReadBinary(std::string_view bytes) {
  std::uint32_t declared = 0;
  std::memcpy(&declared, bytes.data() + kHeader - 4, 4);
  const std::size_t there = (bytes.size() - kHeader) / kFacet;
  const auto refuse = [&](const char* how_many) {
    throw Error("it declares " + std::to_string(declared) + " facets, and " + how_many +
                std::to_string(there) +
                " are present; the file is truncated or damaged: export or copy it again");
  };
  if (declared > there) refuse("");
  FileContents file;
  TriangleMesh& mesh = file.read.mesh;
  Eigen::AlignedBox3d box;
  for (std::uint32_t facet = 0; facet < declared; ++facet) {
    for (const Vec3& corner : CornersOf(bytes, facet)) {
      mesh.vertices.push_back(corner);
      box.extend(corner);
    }
    mesh.triangles.push_back({3 * facet, 3 * facet + 1, 3 * facet + 2});
  }
  file.step = kSingleStep * FarthestOf(mesh);
  if (there == declared) return file;
  // Other bytes after the end are padding, a checksum or a comment; but one more facet is an error.
  const auto next = CornersOf(bytes, declared);
  const double wide = declared > 0 ? box.diagonal().norm() : 0.0;
  const bool near =
      std::ranges::all_of(next, [&](const Vec3& p) { return !(box.exteriorDistance(p) > wide); });
  if (declared == 0 || (near && next[0] != next[1] && next[1] != next[2])) refuse("at least ");
  return file;
}

/// Reads a text STL: words in any case, with any blanks between them.  A solid's name is the rest
/// of its line, whatever words it has.
class TextStl {
 public:
  explicit TextStl(std::string_view text) : text_(text) {}

  ImportedMesh Read() && {
    if (Word() != "solid") {
      throw Error(std::string("it is not STL: text begins with \"solid\", and binary has the "
                              "number of facets after 80 bytes") +
                  kExportAgain);
    }
    do {
      ReadSolid();
    } while (NextSolid());
    return TrianglesOf(std::move(mesh_));
  }

 private:
  /// Reads a word in lower case, with "end solid" as one word.
  std::string Word() {
    std::string word = LowerCase(text_.Word());
    if (word == "end") word += LowerCase(text_.Word());
    return word;
  }
  void Expect(const char* wanted) {
    if (const std::string word = Word(); word != wanted) FailAt(word, wanted);
  }
  [[noreturn]] void FailAt(const std::string& word, const std::string& wanted) {
    text_.Fail((word.empty() ? "it ends" : Quoted(word) + " stands") + " where " + wanted +
               " should, after " + std::to_string(mesh_.size()) + " whole facets");
  }
  bool NextSolid() {
    const std::string word = Word();
    if (!word.empty() && word != "solid") FailAt(word, "solid");
    return !word.empty();
  }

  void ReadSolid() {
    MeshGroup solid{std::string(text_.Line()), mesh_.size(), 0};
    std::string word = Word();
    for (; word == "facet"; word = Word()) ReadFacet();
    if (word != "endsolid") FailAt(word, "endsolid");
    text_.Line();  // the name again
    solid.end = mesh_.size();
    if (!solid.name.empty()) mesh_.groups.push_back(std::move(solid));
  }

  void ReadFacet() {
    std::string word = Word();
    if (word == "normal") {  // followed by any three words
      while (word != "outer" && word != "vertex" && word != "facet" && !word.empty()) word = Word();
    }
    if (word != "outer") FailAt(word, "outer");
    Expect("loop");
    corners_.clear();
    for (word = Word(); word == "vertex"; word = Word()) {
      Vec3 v;
      for (double& number : v) number = text_.Number();
      corners_.push_back(static_cast<std::uint32_t>(mesh_.vertices.size()));
      mesh_.vertices.push_back(v);
    }
    if (word != "endloop" || corners_.size() < 3)
      FailAt(word, corners_.size() < 3 ? "vertex" : "endloop");
    Expect("endfacet");
    mesh_.Add(corners_);
  }

  MeshText text_;
  Polygons mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

FileContents ReadStl(const std::string&, std::string_view text) {
  if (IsBinary(text)) return ReadBinary(text);
  return {TextStl(text).Read()};
}

}  // namespace palpate
