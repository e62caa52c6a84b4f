#pragma once

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scene.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/random.h"

// Mesh files as real programs write them: the same mesh in any layout that its format allows.
namespace palpate::test {

inline TriangleMesh WrittenBox() {  // from (1, 2, 3) to (21, 14, 11)
  return Moved(MakeBox(Vec3(20, 12, 8)), Vec3(11, 8, 7));
}

/// Returns a text with all matches of a pattern replaced.
inline std::string With(const std::string& text, const std::string& pattern,
                        const std::string& by) {
  return std::regex_replace(text, std::regex(pattern), by);
}

template <class T>
void Append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string BinaryStlOf(const TriangleMesh& mesh, const std::string& header = "") {
  std::string bytes = header;
  bytes.resize(80);
  Append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) Append(bytes, std::numeric_limits<float>::quiet_NaN());
    for (int c = 0; c < 3; ++c) {
      for (const double x : Corner(mesh, t, c)) Append(bytes, static_cast<float>(x));
    }
    Append(bytes, std::uint16_t{0x8fff});
  }
  return bytes;
}

/// Returns a .glb with this JSON and a box as its buffer: 8 corners [mm as m], 36 indices, `more`.
inline std::string Glb(std::string json, std::string more = "", bool as_floats = true) {
  std::string buffer;
  const TriangleMesh box = WrittenBox();
  if (as_floats) {
    for (const Vec3& v : box.vertices) {
      for (const double x : v) Append(buffer, static_cast<float>(1e-3 * x));
    }
    for (const auto& triangle : box.triangles) {
      for (const std::uint32_t v : triangle) Append(buffer, static_cast<std::uint16_t>(v));
    }
  }
  buffer += more;
  buffer.resize((buffer.size() + 3) / 4 * 4);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  Append(glb, std::uint32_t{2});
  Append(glb, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()));
  Append(glb, static_cast<std::uint32_t>(json.size()));
  glb += "JSON" + json;
  Append(glb, static_cast<std::uint32_t>(buffer.size()));
  return glb + std::string("BIN\0", 4) + buffer;
}

/// The fields of a glTF JSON with one mesh, which tests may change.
struct GltfFields {
  std::string scene = R"("scene":0,"scenes":[{"nodes":[0]}])", nodes = R"({"mesh":0})",
              position = R"("bufferView":0,"componentType":5126,"count":8,"type":"VEC3")",
              more = "",
              views =
                  R"({"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":72})",
              buffers = R"({"byteLength":168})", primitive = "";
};
inline std::string Json(const GltfFields& f) {
  return R"({"asset":{"version":"2.0"},)" + f.scene + (f.scene.empty() ? "" : ",") +
         R"("nodes":[)" + f.nodes +
         R"(],"meshes":[{"name":"","primitives":[{"attributes":{"POSITION":0},"indices":1)" +
         f.primitive + R"(}]}],"accessors":[{)" + f.position +
         R"(},{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}],"bufferViews":[)" +
         f.views + R"(],"buffers":[)" + f.buffers + "]" + f.more + "}";
}

/// Writes tokens in any style a program may use: varied blanks, signs, exponents and line ends.
class AnyHand {
 public:
  explicit AnyHand(std::uint32_t seed) : random_(seed) { end_ = OneOf({"\n", "\r\n", "\r"}); }

  std::string OneOf(std::vector<std::string> words) {
    return words[static_cast<std::size_t>(random_.Below(static_cast<int>(words.size())))];
  }
  bool Maybe() { return random_.Below(2) == 0; }
  std::string Blank() { return OneOf({" ", "\t", "  ", " \t "}); }
  std::string Indent() { return OneOf({"", "", " ", "\t"}); }
  std::string End() { return OneOf({"", "", " "}) + end_; }
  const std::string& end() const { return end_; }
  std::string Number(double x) {
    char word[40];
    std::snprintf(word, sizeof word, OneOf({"%.9g", "%.8e", "%+.9g", "%.9E"}).c_str(), x);
    return word;
  }
  /// Makes triangles with three distinct vertices each.
  TriangleMesh Mesh() {
    TriangleMesh mesh;
    const int vertices = 3 + random_.Below(8);
    for (int v = 0; v < vertices; ++v) {
      mesh.vertices.push_back(random_.InCube(100.0).cast<float>().cast<double>());
    }
    for (int t = 1 + random_.Below(8); t > 0; --t) {
      const auto any = [&] { return static_cast<std::uint32_t>(random_.Below(vertices)); };
      const std::uint32_t a = any();
      mesh.triangles.push_back({a, (a + 1) % static_cast<std::uint32_t>(vertices),
                                (a + 2) % static_cast<std::uint32_t>(vertices)});
    }
    return mesh;
  }
  Random& random() { return random_; }

 private:
  Random random_;
  std::string end_;
};

inline std::string AnyObj(const TriangleMesh& mesh, AnyHand& hand) {
  std::string text = hand.OneOf({"", "\xef\xbb\xbf", "# by hand"}) + hand.End();
  const std::string behind = hand.OneOf({"", " 0.5", " 1 0 0", " 1 0 0 1", " # here"});
  const bool early = hand.Maybe();  // writes faces as soon as their corners are written
  std::size_t next = 0;
  const auto faces = [&](std::size_t vertices) {
    for (; next < mesh.triangles.size(); ++next) {
      const auto& t = mesh.triangles[next];
      if (std::max({t[0], t[1], t[2]}) >= vertices) return;
      text += hand.Indent() + "f";
      for (const std::uint32_t v : t) {
        const auto number = hand.Maybe() ? std::int64_t{v} + 1
                                         : std::int64_t{v} - static_cast<std::int64_t>(vertices);
        text += hand.OneOf({" ", "\t", " \\" + hand.end()}) + std::to_string(number) +
                hand.OneOf({"", "/1", "//1", "/1/1"});
      }
      text += hand.End();
    }
  };
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    text += hand.Indent() + "v";
    for (const double x : mesh.vertices[v]) text += hand.Blank() + hand.Number(x);
    text += behind + hand.End() +
            hand.OneOf({"", "vn nan nan nan" + hand.end(), "g part" + hand.end()});
    if (early) faces(v + 1);
  }
  faces(mesh.vertices.size());
  if (hand.Maybe()) text.resize(text.find_last_not_of(" \r\n") + 1);
  return text;
}

inline std::string AnyStl(const TriangleMesh& mesh, AnyHand& hand) {
  if (hand.Maybe()) {
    return BinaryStlOf(mesh, hand.OneOf({"", "solid facet normal", "scanner"})) +
           hand.OneOf({"", "\n", std::string(60, '\0'), "0123456789"});
  }
  const bool large = hand.Maybe();
  const auto word = [&](std::string w) {
    if (large) std::ranges::transform(w, w.begin(), [](char c) { return std::toupper(c); });
    return hand.Indent() + w;
  };
  std::string text = hand.OneOf({"", "\xef\xbb\xbf", "\n"}) + word("solid") +
                     hand.OneOf({"", " a facet"}) + hand.End();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += word("facet normal") + hand.OneOf({" 0 0 1", " nan nan nan"}) + hand.End() +
            word("outer loop") + hand.End();
    for (int c = 0; c < 3; ++c) {
      text += word("vertex");
      for (const double x : Corner(mesh, t, c)) text += hand.Blank() + hand.Number(x);
      text += hand.End();
    }
    text += word("endloop") + hand.End() + word(hand.OneOf({"endfacet", "end facet"})) + hand.End();
  }
  return text + word(hand.OneOf({"endsolid a facet", "end solid", "endsolid"})) +
         hand.OneOf({"", hand.End()});
}

inline std::string AnyPly(const TriangleMesh& mesh, AnyHand& hand) {
  const std::string format = hand.OneOf({"ascii", "binary_little_endian", "binary_big_endian"});
  const std::string real = hand.OneOf({"float", "double"});
  const std::string index = hand.OneOf({"uchar", "short", "int", "uint"});
  const bool in_strips = hand.random().Below(4) == 0;
  const bool extra = hand.Maybe(), faces_first = hand.random().Below(4) == 0;
  std::string body;
  const auto put = [&](double value, const std::string& type) {
    if (format == "ascii") {
      body += (type == real ? hand.Number(value) : std::to_string(static_cast<int>(value))) +
              hand.Blank();
      return;
    }
    const std::size_t begin = body.size();
    if (type == "float") Append(body, static_cast<float>(value));
    if (type == "double") Append(body, value);
    if (type == "uchar") Append(body, static_cast<std::uint8_t>(value));
    if (type == "short") Append(body, static_cast<std::int16_t>(value));
    if (type == "int") Append(body, static_cast<std::int32_t>(value));
    if (type == "uint") Append(body, static_cast<std::uint32_t>(value));
    if (format == "binary_big_endian") {
      std::reverse(body.begin() + static_cast<std::ptrdiff_t>(begin), body.end());
    }
  };
  std::string header = "ply" + hand.end() + "format " + format + " 1.0" + hand.end();
  const auto property = [&](const std::string& what) { header += "property " + what + hand.end(); };
  const auto end_row = [&] { body += format == "ascii" ? hand.End() : ""; };
  const auto vertices = [&] {
    header += "element vertex " + std::to_string(mesh.vertices.size()) + hand.end();
    if (extra) property("uchar red");
    for (const char* axis : {"x", "y", "z"}) property(real + " " + axis);
    if (extra) property("list uchar short marks");
    for (const Vec3& v : mesh.vertices) {
      if (extra) put(10, "uchar");
      for (const double x : v) put(x, real);
      if (extra) put(1, "uchar"), put(10, "short");
      end_row();
    }
  };
  const auto strips = [&] {  // one strip, restarted for each triangle
    header += "element tristrips 1" + hand.end();
    property("list int int vertex_indices");
    put(4.0 * static_cast<double>(mesh.triangles.size()), "int");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t v : triangle) put(v, "int");
      put(-1, "int");
    }
    end_row();
  };
  const auto faces = [&] {
    if (in_strips) return strips();
    header += "element face " + std::to_string(mesh.triangles.size()) + hand.end();
    if (extra) property("short quality");
    property("list uchar " + index + hand.OneOf({" vertex_index", " vertex_indices"}));
    for (const auto& triangle : mesh.triangles) {
      if (extra) put(10, "short");
      put(3, "uchar");
      for (const std::uint32_t v : triangle) put(v, index);
      end_row();
    }
  };
  if (faces_first) faces();
  vertices();
  if (!faces_first) faces();
  return header + hand.OneOf({"", "comment end_header" + hand.end()}) + "end_header" + hand.end() +
         body + hand.OneOf({"", "\n"});
}

inline std::string AnyGlb(const TriangleMesh& mesh, AnyHand& hand) {
  const std::size_t stride = hand.Maybe() ? 12 : 20, begin = hand.Maybe() ? 0 : 8;
  const int index = std::stoi(hand.OneOf({"5121", "5123", "5125"}));
  std::string buffer(begin, '\x7f');
  const bool sparse = hand.Maybe();  // the first one is stored elsewhere
  for (const Vec3& v : mesh.vertices) {
    for (const double x : v)
      Append(buffer, sparse && &v == &mesh.vertices[0] ? 0.f : static_cast<float>(x));
    buffer.append(stride - 12, '\x7f');
  }
  const std::size_t positions = buffer.size();
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      if (index == 5121) Append(buffer, static_cast<std::uint8_t>(v));
      if (index == 5123) Append(buffer, static_cast<std::uint16_t>(v));
      if (index == 5125) Append(buffer, v);
    }
  }
  const std::size_t indices = buffer.size();
  Append(buffer, std::uint32_t{0});
  for (const double x : mesh.vertices[0]) Append(buffer, static_cast<float>(x));
  const auto text = [](std::size_t n) { return std::to_string(n); };
  std::string json =
      Json({.position =
                R"("bufferView":0,"byteOffset":)" + text(begin) +
                R"(,"componentType":5126,"type":"VEC3","count":)" + text(mesh.vertices.size()) +
                (sparse ? R"(,"sparse":{"count":1,"indices":{"bufferView":2,"componentType":5125},
"values":{"bufferView":3}})"
                        : ""),
            .views = R"({"buffer":0,"byteStride":)" + text(stride) + R"(,"byteLength":)" +
                     text(positions) + R"(},{"buffer":0,"byteOffset":)" + text(positions) +
                     R"(,"byteLength":)" + text(indices - positions) +
                     R"(},{"buffer":0,"byteLength":4,"byteOffset":)" + text(indices) +
                     R"(},{"buffer":0,"byteLength":12,"byteOffset":)" + text(indices + 4) + "}"});
  json = With(json, R"("componentType":5123,"count":36)",
              R"("componentType":)" + text(static_cast<std::size_t>(index)) + R"(,"count":)" +
                  text(3 * mesh.triangles.size()));
  return Glb(hand.Maybe() ? With(json, ",", ",\n\t") : json, buffer, false) +
         hand.OneOf({"", "\n", "more"});
}

}  // namespace palpate::test
