#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/bundle_hash.h"
#include "scenes/scene.h"

namespace palpate {

/// Version of the bundle's layout.  Bundles of another version are rejected.
inline constexpr std::uint32_t kBundleVersion = 2;

/// Whether to pack the information for people, too: Body::remarks and SphereTree::origin.  It is
/// kept in files that people read, and left out of a scene that is sent, whose bytes then do not
/// depend on it.
enum class Remarks { kLeaveOut, kKeep };
/// Packs a scene into bytes: a 40-byte header (magic, version, content key, size, XXH64) and a
/// FlatBuffer (idl/scene.fbs), little-endian.  Equal scenes give equal bytes.
/// @param content_key  hash of what the scene was made from, for the cache; 0 if not needed.
std::vector<std::uint8_t> PackScene(const Scene& scene, std::uint64_t content_key = 0,
                                    Remarks remarks = Remarks::kLeaveOut);

/// Unpacks a scene after checking everything: magic, version, size, checksum, the structure of the
/// FlatBuffer, and that all indices and counts agree.  Throws Error with the defect and a remedy.
/// @param source  names the bytes in messages.
Scene UnpackScene(std::span<const std::uint8_t> bytes, const std::string& source);

/// Returns whether two bodies share one geometry in a bundle: mesh and tree are bitwise equal.
bool SameGeometry(const Body& a, const Body& b);

/// Returns the key that PackScene was given.  Throws Error if the header is wrong, as UnpackScene.
std::uint64_t ContentKey(std::span<const std::uint8_t> bytes, const std::string& source);

/// Throws Error if no scene file could describe the scene, which PackScene does not check: it has
/// no tool, no object, or an invalid name.
void CheckPackable(const Scene& scene);

/// Returns whether the bytes begin as a bundle does.
bool LooksLikeBundle(std::string_view bytes);

/// Writes the whole file or, if that fails, leaves the old one; Ctrl-C waits for it.  Throws Error;
/// makes no folder.
void WriteFileAtomically(const std::string& file, std::span<const std::uint8_t> bytes);

/// Returns the XXH64 of the bytes, with a seed to chain hashes.
std::uint64_t HashBytes(std::string_view bytes, std::uint64_t seed);

}  // namespace palpate
