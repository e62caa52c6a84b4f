#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/bundle_hash.h"
#include "scenes/scene.h"

namespace palpate {

/// Version of the bundle's layout.  Bundles of another version are refused, never guessed at.
inline constexpr std::uint32_t kBundleVersion = 2;

/// Whether what is for people is packed, too, Body::remarks and SphereTree::origin: they are for
/// those who read a file, and a scene that travels has the same bytes with and without them.
enum class Remarks { kLeaveOut, kKeep };
/// Changes with what kKeep keeps, so that older cached scenes are built anew and say it.
inline constexpr std::uint32_t kRemarksVersion = 1;

/// A scene as bytes: a 40-byte header (magic, version, content key, size, XXH64) and a FlatBuffer
/// (idl/scene.fbs), little-endian.  Equal scenes give equal bytes.
/// @param content_key  what the scene was made from, kept for the cache; 0 where nobody asks.
std::vector<std::uint8_t> PackScene(const Scene& scene, std::uint64_t content_key = 0,
                                    Remarks remarks = Remarks::kLeaveOut);

/// Checks everything before it believes anything: magic, version, size, checksum, the FlatBuffer's
/// structure, and that all indices and counts agree.  Throws Error with what is wrong and a remedy.
/// @param source  names the bytes in messages.
Scene UnpackScene(std::span<const std::uint8_t> bytes, const std::string& source);

/// Whether two bodies are one geometry in a bundle: mesh and tree are the same bits.
bool SameGeometry(const Body& a, const Body& b);

/// The key that PackScene was given.  Throws Error like UnpackScene, for the header.
std::uint64_t ContentKey(std::span<const std::uint8_t> bytes, const std::string& source);

/// Throws Error where no scene file could have the scene, which PackScene takes as it comes: no
/// tool or object, a name that is none.
void CheckPackable(const Scene& scene);

/// True where the bytes begin as a bundle does.
bool LooksLikeBundle(std::string_view bytes);

/// Writes the whole file or, where that fails, leaves what was there; Ctrl-C waits for it.  Throws
/// Error.
void WriteFileAtomically(const std::string& file, std::span<const std::uint8_t> bytes);

/// XXH64 of the bytes, chained by the seed.
std::uint64_t HashBytes(std::string_view bytes, std::uint64_t seed);

}  // namespace palpate
