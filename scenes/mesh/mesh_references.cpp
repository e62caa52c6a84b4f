#include "scenes/mesh/mesh_references.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <utility>

#include "common/error.h"
#include "common/json/json_file.h"
#include "scenes/mesh/mesh_format.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Returns the JSON of a .glb, its first chunk; empty if there is none, which its importer reports.
std::string_view JsonChunk(std::string_view glb) {
  constexpr std::size_t kHeader = 20;  // the file's twelve bytes and the chunk's eight
  if (glb.size() < kHeader) return {};
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return glb.substr(kHeader, length);
}

/// Decodes a URI: "my%20mesh.bin" becomes "my mesh.bin".
std::string Decoded(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned char byte = 0;
    const char* const digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      name += static_cast<char>(byte);
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

/// Returns whether a name leads out of the mesh's folder: a mesh from elsewhere must not make the
/// program open files that only its user may read.
bool LeadsOut(const std::string& name) {
  const fs::path path(name);
  return path.is_absolute() || name.find("://") != std::string::npos ||
         name.find('\\') != std::string::npos || name.find('\0') != std::string::npos ||
         std::find(path.begin(), path.end(), "..") != path.end();
}

}  // namespace

std::optional<MeshReference> ReferenceOf(const std::string& file, const JsonNode& buffer) {
  const auto uri = buffer.Find("uri");
  if (!uri || uri->Text().starts_with("data:")) return std::nullopt;
  const std::string name = Decoded(uri->String());
  if (LeadsOut(name)) {
    uri->Fail("\"" + name +
              "\" is outside the mesh's folder; put the buffer beside the mesh, or export a .glb, "
              "which contains it");
  }
  return MeshReference{uri->String(), (fs::path(file).parent_path() / name).string()};
}

std::vector<MeshReference> FindMeshReferences(const std::string& file, std::string_view text) {
  const std::string format = MeshFormatOf(file);
  if (format != "gltf" && format != "glb") return {};
  if (format == "glb") text = JsonChunk(text);
  // glTF pads its JSON with spaces.  If there is nothing else, its importer reports it.
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return {};
  const JsonNode root = JsonNode::Parse(text, file);
  std::vector<MeshReference> references;
  const auto buffers = root.Find("buffers");
  if (!buffers) return references;
  for (const JsonNode& buffer : buffers->Items()) {
    if (auto reference = ReferenceOf(file, buffer)) references.push_back(std::move(*reference));
  }
  return references;
}

}  // namespace palpate
