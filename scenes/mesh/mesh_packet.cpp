#include "scenes/mesh/mesh_packet.h"

#include <cstring>

#include "common/error.h"

namespace palpate {
namespace {

constexpr std::uint64_t kMagic = 0x3168736d706c6170;  // "palpmsh1"

struct Header {
  std::uint64_t magic = kMagic;
  std::uint64_t vertices = 0, triangles = 0, groups = 0;
};
struct Part {
  std::uint32_t begin = 0, end = 0, name_bytes = 0;
};
static_assert(sizeof(Vec3) == 3 * sizeof(double));

class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  void Read(std::vector<T>& out, std::uint64_t count) {
    if (count > rest_.size() / sizeof(T)) Refuse();
    out.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(out.data()), rest_.data(), count * sizeof(T));
    rest_.remove_prefix(count * sizeof(T));
  }
  template <class T>
  T Read() {
    std::vector<T> one;
    Read(one, 1);
    return one.front();
  }
  std::string ReadText(std::size_t size) {
    if (size > rest_.size()) Refuse();
    const std::string text(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return text;
  }
  void End() const {
    if (!rest_.empty()) Refuse();
  }
  [[noreturn]] static void Refuse() { throw Error("the data read from it is inconsistent"); }

 private:
  std::string_view rest_;
};

template <class T>
void Append(std::string& bytes, const T* items, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(items), count * sizeof(T));
}

}  // namespace

std::string PackMesh(const ImportedMesh& read) {
  Header header;
  header.vertices = read.mesh.vertices.size();
  header.triangles = read.mesh.triangles.size();
  header.groups = read.groups.size();
  std::string bytes;
  bytes.reserve(sizeof header + header.vertices * sizeof(Vec3) + header.triangles * 12);
  Append(bytes, &header, 1);
  Append(bytes, read.mesh.vertices.data(), read.mesh.vertices.size());
  Append(bytes, read.mesh.triangles.data(), read.mesh.triangles.size());
  for (const MeshGroup& group : read.groups) {
    const Part part{group.begin, group.end, static_cast<std::uint32_t>(group.name.size())};
    Append(bytes, &part, 1);
    bytes += group.name;
  }
  return bytes;
}

ImportedMesh UnpackMesh(std::string_view bytes) {
  Cursor cursor(bytes);
  const auto header = cursor.Read<Header>();
  if (header.magic != kMagic) Cursor::Refuse();
  ImportedMesh read;
  cursor.Read(read.mesh.vertices, header.vertices);
  cursor.Read(read.mesh.triangles, header.triangles);
  for (std::uint64_t i = 0; i < header.groups; ++i) {
    const Part part = cursor.Read<Part>();
    if (part.begin > part.end || part.end > header.triangles) Cursor::Refuse();
    read.groups.push_back({cursor.ReadText(part.name_bytes), part.begin, part.end});
  }
  cursor.End();
  return read;
}

}  // namespace palpate
