#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "scenes/importer/mesh_text.h"
#include "scenes/importer/raw_number.h"
#include "scenes/importer/readers.h"
#include "scenes/mesh/mesh_format.h"
#include "scenes/mesh/mesh_import_limits.h"
#include "scenes/mesh/mesh_references.h"

namespace palpate {
namespace {

constexpr std::int64_t kMost = std::int64_t{1} << 32;  // limit of bytes, numbers and entries

std::uint32_t NumberAt(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint32_t>(ReadRaw<std::uint32_t>(bytes.data() + at));
}

/// The chunks of a .glb: after magic, version and length, each has a length, a type and contents;
/// JSON comes first, then the first buffer.  Bytes beyond the file's length are ignored.
struct Chunks {
  std::string_view json, buffer;
};
Chunks ChunksOf(std::string_view glb) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBuffer = 0x004e4942;
  const std::string export_again = "; the file is cut short or damaged, export or copy it again";
  if (glb.size() < kHeader + kChunkHeader || !glb.starts_with("glTF")) {
    throw Error("it is not a .glb" + export_again);
  }
  if (const std::uint32_t version = NumberAt(glb, 4); version != 2) {
    throw Error("it is of glTF version " + std::to_string(version) + "; export it as glTF 2.0");
  }
  const std::size_t declared = NumberAt(glb, 8);
  if (declared > glb.size()) {
    throw Error("it declares " + std::to_string(declared) + " bytes, and " +
                std::to_string(glb.size()) + " are there" + export_again);
  }
  Chunks chunks;
  for (std::size_t at = kHeader; at < declared;) {
    const std::size_t left = declared - at;
    if (left < kChunkHeader || NumberAt(glb, at) > left - kChunkHeader) {
      throw Error("the lengths of its chunks do not match its own" + export_again);
    }
    const std::string_view contents = glb.substr(at + kChunkHeader, NumberAt(glb, at));
    if (at == kHeader && NumberAt(glb, at + 4) == kJson) chunks.json = contents;
    if (NumberAt(glb, at + 4) == kBuffer && chunks.buffer.empty()) chunks.buffer = contents;
    at += kChunkHeader + contents.size();
  }
  if (chunks.json.empty()) throw Error("its first chunk is not JSON" + export_again);
  return chunks;
}

/// Decodes "data:application/octet-stream;base64,AAEC".
std::string Decoded(const JsonNode& uri) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string text = uri.Text();
  const std::size_t begin = text.find(";base64,");
  if (begin == std::string::npos) uri.Fail("is not base64; export a .glb");
  std::string bytes;
  std::uint32_t bits = 0;
  int known = 0;
  for (std::size_t i = begin + 8; i < text.size() && text[i] != '='; ++i) {
    const std::size_t digit = kDigits.find(text[i]);
    if (digit == std::string_view::npos) uri.Fail("is not base64; export it again, as a .glb");
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((known += 6) < 8) continue;
    known -= 8;
    bytes += static_cast<char>(bits >> known & 0xff);
  }
  return bytes;
}

/// Reads a glTF 2.0: all meshes of its scene in the poses of their nodes, quantised, sparse, in
/// strips or fans.  Rejects by name what moves vertices in another way, and every required
/// extension that is not known to concern appearance only.
class Gltf {
 public:
  Gltf(const std::string& file, std::string_view text) : Gltf(file, ChunksIn(file, text)) {}

  FileContents Read() && {
    const JsonNode version = root_.At("asset").At("version");
    if (!version.String().starts_with("2.")) version.Fail("is not read; export it as glTF 2.0");
    CheckExtensions();
    if (meshes_.empty()) root_.Fail("holds no meshes; export surfaces");
    for (const auto& [node, X] : PlacedNodes()) ReadNode(nodes_[node], X);
    return std::move(file_);
  }

 private:
  using Matrix = Eigen::Affine3d;

  static Chunks ChunksIn(const std::string& file, std::string_view text) {
    return MeshFormatOf(file) == "glb" ? ChunksOf(text) : Chunks{MeshText(text).rest(), {}};
  }

  Gltf(const std::string& file, const Chunks& chunks)
      : name_(file),
        root_(JsonNode::Parse(chunks.json, file)),
        nodes_(List("nodes")),
        meshes_(List("meshes")),
        accessors_(List("accessors")),
        views_(List("bufferViews")) {
    for (const JsonNode& buffer : List("buffers")) ReadBuffer(buffer, chunks.buffer);
  }

  std::vector<JsonNode> List(std::string_view field) const {
    const auto list = root_.Find(field);
    return list ? list->Items() : std::vector<JsonNode>{};
  }
  static std::size_t Count(const JsonNode& node, std::string_view field, std::size_t otherwise) {
    const auto number = node.Find(field);
    return number ? static_cast<std::size_t>(number->Integer(0, kMost)) : otherwise;
  }
  /// Returns the entry of a list whose index is in a field.
  template <class T>
  static const T& Entry(const std::vector<T>& list, const JsonNode& number) {
    if (list.empty()) number.Fail("refers to a list entry that does not exist; export it again");
    return list[static_cast<std::size_t>(
        number.Integer(0, static_cast<std::int64_t>(list.size()) - 1))];
  }
  static bool HasExtension(const JsonNode& node, std::string_view name) {
    const auto extensions = node.Find("extensions");
    return extensions && extensions->Has(name);
  }

  void CheckExtensions() const {
    const auto required = root_.Find("extensionsRequired");
    if (!required) return;
    for (const JsonNode& extension : required->Items()) {
      const std::string name = extension.String();
      const auto about = [&](const char* what) { return name.find(what) != std::string::npos; };
      // With meshopt compression there may be an uncompressed copy, whose data are used.
      if (name == "KHR_mesh_quantization" || name == "EXT_meshopt_compression" ||
          about("_materials_") || about("_texture_") || about("_lights_")) {
        continue;
      }
      extension.Fail("the file needs \"" + name +
                     "\", which is not read; export it without, uncompressed");
    }
  }

  // --- numbers ---

  void ReadBuffer(const JsonNode& buffer, std::string_view chunk) {
    const auto uri = buffer.Find("uri");
    if (const auto reference = ReferenceOf(name_, buffer)) {
      if (IsPackedMesh(name_)) {
        uri->Fail("refers to a second file, \"" + reference->uri +
                  "\", which a compressed mesh must not; decompress it, or export a .glb");
      }
      try {
        buffers_.push_back(ReadWholeFile(reference->file, kLargestMeshFile));
      } catch (const Error& error) {
        uri->Fail(std::string("its buffer is missing (") + error.what() +
                  "); keep it beside the mesh, or export a .glb, which holds it");
      }
    } else if (uri) {
      buffers_.push_back(Decoded(*uri));
    } else {
      buffers_.emplace_back(buffers_.empty() ? chunk : std::string_view{});
    }
  }

  std::string_view BytesOf(const JsonNode& view) const {
    const std::string& buffer = Entry(buffers_, view.At("buffer"));
    if (buffer.empty() && HasExtension(view, "EXT_meshopt_compression")) {
      view.Fail(
          "is compressed by \"EXT_meshopt_compression\", without a plain copy; export it "
          "uncompressed (gltfpack without -c)");
    }
    const std::size_t begin = Count(view, "byteOffset", 0);
    const std::size_t bytes = Count(view.At("byteLength"));
    if (begin > buffer.size() || bytes > buffer.size() - begin) {
      view.Fail("reaches beyond the end of its buffer, which has " + std::to_string(buffer.size()) +
                " bytes; the file is truncated or damaged: export it again");
    }
    return std::string_view(buffer).substr(begin, bytes);
  }
  static std::size_t Count(const JsonNode& number) {
    return static_cast<std::size_t>(number.Integer(0, kMost));
  }

  static constexpr std::int64_t kByte = 5120, kFloat = 5126;

  /// Reads `count` entries of `width` numbers each, from the view that `holder` names.
  /// @param take  called with each entry's index and numbers.
  template <class Take>
  void Walk(const JsonNode& holder, std::int64_t type, bool normalized, std::size_t width,
            std::size_t count, Take take) const {
    constexpr std::int64_t kUnknown = 5124;
    if (type == kUnknown) holder.Fail("has numbers of an unknown type, 5124; export it again");
    const RawType& raw = kRawTypes[type - kByte];
    const std::size_t size = raw.bytes;
    const JsonNode& view = Entry(views_, holder.At("bufferView"));
    const std::string_view bytes = BytesOf(view);
    const std::size_t begin = Count(holder, "byteOffset", 0);
    const std::size_t stride = std::max(Count(view, "byteStride", 0), size * width);
    if (count > 0 && (begin > bytes.size() || (bytes.size() - begin) / stride < count - 1 ||
                      bytes.size() - begin - (count - 1) * stride < size * width)) {
      holder.Fail("reaches beyond the end of its view, which has " + std::to_string(bytes.size()) +
                  " bytes; the file is damaged, export it again");
    }
    std::array<double, 3> numbers{};
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < width; ++c) {
        numbers[c] = raw.read(bytes.data() + begin + i * stride + c * size);
        if (normalized) numbers[c] = std::max(numbers[c] / raw.one, -1.0);
      }
      take(i, numbers);
    }
  }

  /// Returns all numbers of an accessor, `width` for each entry.
  std::vector<double> Numbers(const JsonNode& accessor, std::size_t width) const {
    const std::string wanted = width == 1 ? "SCALAR" : "VEC3";
    if (accessor.At("type").String() != wanted) accessor.At("type").Fail("must be " + wanted);
    const std::int64_t type = accessor.At("componentType").Integer(kByte, kFloat);
    const auto normalized = accessor.Find("normalized");
    const bool whole = normalized && normalized->Boolean();
    const std::size_t count = Count(accessor.At("count"));
    const auto sparse = accessor.Find("sparse");
    if (!sparse && !accessor.Has("bufferView")) {
      accessor.Fail("has no data; export it uncompressed");
    }
    // Zeros can be declared without any bytes, and what is made of them takes three times as much.
    if (count * width * sizeof(double) > ImportLimitsFor(name_).bytes / 4) throw std::bad_alloc();
    std::vector<double> all(count * width);
    const auto put = [&](std::size_t i, const std::array<double, 3>& numbers) {
      std::copy_n(numbers.begin(), width, all.begin() + static_cast<std::ptrdiff_t>(i * width));
    };
    if (accessor.Has("bufferView")) Walk(accessor, type, whole, width, count, put);
    if (!sparse) return all;
    const std::size_t changed = Count(sparse->At("count"));
    const JsonNode indices = sparse->At("indices");
    std::vector<std::size_t> which(std::min(changed, count));
    if (changed > count) sparse->Fail("changes more entries than exist; export it again");
    Walk(indices, indices.At("componentType").Integer(kByte, kFloat), false, 1, changed,
         [&](std::size_t i, const std::array<double, 3>& numbers) {
           if (!(numbers[0] >= 0.0 && numbers[0] < static_cast<double>(count))) {
             indices.Fail("refers to an entry that does not exist; export it again");
           }
           which[i] = static_cast<std::size_t>(numbers[0]);
         });
    Walk(sparse->At("values"), type, whole, width, changed,
         [&](std::size_t i, const std::array<double, 3>& numbers) { put(which[i], numbers); });
    return all;
  }

  // --- nodes ---

  static Matrix PlaceOf(const JsonNode& node) {
    Matrix X = Matrix::Identity();
    if (const auto matrix = node.Find("matrix")) {
      const auto numbers = matrix->Items(16);
      for (std::size_t i = 0; i < 16; ++i) {  // column by column
        if (i % 4 < 3) X(static_cast<int>(i % 4), static_cast<int>(i / 4)) = numbers[i].Number();
      }
      return X;
    }
    if (const auto translation = node.Find("translation")) X.translate(translation->Vector());
    if (const auto rotation = node.Find("rotation")) {
      const auto xyzw = rotation->Items(4);
      const Quat q(xyzw[3].Number(), xyzw[0].Number(), xyzw[1].Number(), xyzw[2].Number());
      if (!(std::abs(q.norm() - 1.0) < 0.01))
        rotation->Fail("is not a unit quaternion; export it again");
      X.rotate(q.normalized());
    }
    if (const auto scale = node.Find("scale")) X.scale(scale->Vector());
    return X;
  }

  /// Returns the nodes of the scene with their poses.  Without a default scene, of the first scene;
  /// without any scene, all nodes that are in no other.
  std::vector<std::pair<std::size_t, Matrix>> PlacedNodes() const {
    std::vector<bool> is_child(nodes_.size()), met(nodes_.size());
    std::vector<std::pair<std::size_t, Matrix>> placed;
    const auto place = [&](const JsonNode& number, const Matrix& parent) {
      const JsonNode& node = Entry(nodes_, number);
      const auto which = static_cast<std::size_t>(&node - nodes_.data());
      // Must be a tree: in a graph, few nodes could stand for too many.
      if (met[which]) number.Fail("the node is listed twice; export it again");
      met[which] = true;
      placed.emplace_back(which, parent * PlaceOf(node));
    };
    const std::vector<JsonNode> scenes = List("scenes");
    if (!scenes.empty()) {
      const auto by_default = root_.Find("scene");
      const JsonNode& scene = by_default ? Entry(scenes, *by_default) : scenes.front();
      if (const auto roots = scene.Find("nodes")) {
        for (const JsonNode& root : roots->Items()) place(root, Matrix::Identity());
      }
    } else {
      for (const JsonNode& node : nodes_) {
        const auto children = node.Find("children");
        if (!children) continue;
        for (const JsonNode& child : children->Items()) {
          is_child[static_cast<std::size_t>(&Entry(nodes_, child) - nodes_.data())] = true;
        }
      }
      for (std::size_t n = 0; n < nodes_.size(); ++n) {
        if (is_child[n]) continue;
        met[n] = true;
        placed.emplace_back(n, PlaceOf(nodes_[n]));
      }
    }
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const auto [node, X] = placed[i];
      const auto children = nodes_[node].Find("children");
      if (!children) continue;
      for (const JsonNode& child : children->Items()) place(child, X);
    }
    return placed;
  }

  void ReadNode(const JsonNode& node, const Matrix& X) {
    const auto number = node.Find("mesh");
    if (!number || X.linear().isZero(0.0)) return;  // scaled to nothing: hidden
    const JsonNode& mesh = Entry(meshes_, *number);
    if (HasExtension(node, "EXT_mesh_gpu_instancing")) {
      node.Fail(
          "is instanced by \"EXT_mesh_gpu_instancing\", which is not supported; export it with a "
          "node for each instance");
    }
    if (node.Has("skin")) {
      node.Fail(
          "is deformed by bones (\"skin\"), which is not supported; apply them in a mesh editor");
    }
    for (const JsonNode& of : {node, mesh}) {
      const auto weights = of.Find("weights");
      if (!weights) continue;
      for (const JsonNode& weight : weights->Items()) {
        if (weight.Number() == 0.0) continue;
        weight.Fail(
            "a shape key deforms the mesh, which is not supported; apply it in a mesh editor");
      }
    }
    const auto begin = static_cast<std::uint32_t>(file_.read.mesh.triangles.size());
    for (const JsonNode& primitive : mesh.At("primitives").Items()) ReadPrimitive(primitive, X);
    const auto end = static_cast<std::uint32_t>(file_.read.mesh.triangles.size());
    const std::string of_mesh = NameOf(mesh), of_node = NameOf(node);
    if (!of_mesh.empty()) file_.read.groups.push_back({of_mesh, begin, end});
    if (!of_node.empty() && of_node != of_mesh) file_.read.groups.push_back({of_node, begin, end});
  }
  static std::string NameOf(const JsonNode& node) {
    const auto name = node.Find("name");
    return name ? name->Text() : "";
  }

  void ReadPrimitive(const JsonNode& primitive, const Matrix& X) {
    enum Mode : std::int64_t { kTriangles = 4, kStrip = 5, kFan = 6 };
    const auto given = primitive.Find("mode");
    const std::int64_t mode = given ? given->Integer(0, kFan) : kTriangles;
    if (mode < kTriangles) return;  // points and lines
    const JsonNode& positions = Entry(accessors_, primitive.At("attributes").At("POSITION"));
    if (HasExtension(primitive, "KHR_draco_mesh_compression") && !positions.Has("bufferView")) {
      primitive.Fail(
          "is compressed by \"KHR_draco_mesh_compression\", without a plain copy; export it "
          "uncompressed");
    }
    TriangleMesh& mesh = file_.read.mesh;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::vector<double> numbers = Numbers(positions, 3);
    const std::size_t count = numbers.size() / 3;
    double farthest = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 v = Vec3::Map(numbers.data() + 3 * i);
      if (v.allFinite()) farthest = std::max(farthest, v.cwiseAbs().maxCoeff());
      mesh.vertices.push_back(X * v);
    }
    if (positions.At("componentType").Integer(kByte, kFloat) == kFloat) {
      file_.step =
          std::max(file_.step, kSingleStep * farthest * X.linear().colwise().norm().maxCoeff());
    }

    std::vector<std::uint32_t> corners;
    if (const auto indices = primitive.Find("indices")) {
      for (const double v : Numbers(Entry(accessors_, *indices), 1)) {
        if (!(v >= 0.0 && v < static_cast<double>(count))) {
          indices->Fail("names vertex " + std::to_string(v) + " of " + std::to_string(count) +
                        "; the file is damaged, export it again");
        }
        corners.push_back(first + static_cast<std::uint32_t>(v));
      }
    } else {
      for (std::size_t v = 0; v < count; ++v)
        corners.push_back(first + static_cast<std::uint32_t>(v));
    }
    if (mode == kTriangles && corners.size() % 3 != 0) {
      primitive.Fail("has " + std::to_string(corners.size()) +
                     " corners, which is not a multiple of three; export it again");
    }
    const bool mirrored = X.linear().determinant() < 0.0;  // then its faces are wound the other way
    for (std::size_t i = 0; i + 2 < corners.size(); i += mode == kTriangles ? 3 : 1) {
      std::array<std::uint32_t, 3> t{corners[mode == kFan ? 0 : i], corners[i + 1], corners[i + 2]};
      // Strips contain triangles with a repeated corner, which only lead on.
      if (mode != kTriangles && (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])) continue;
      if (mirrored != (mode == kStrip && i % 2 == 1)) std::swap(t[1], t[2]);
      mesh.triangles.push_back(t);
    }
  }

  const std::string& name_;
  JsonNode root_;
  std::vector<JsonNode> nodes_, meshes_, accessors_, views_;
  std::vector<std::string> buffers_;
  FileContents file_;
};

}  // namespace

FileContents ReadGltf(const std::string& file, std::string_view text) {
  return Gltf(file, text).Read();
}

}  // namespace palpate
